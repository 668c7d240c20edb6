// The therapist's own sum of measures: which, and times what. Without a line there is none.
import { ActionIcon, Button, NumberInput, Select } from '@mantine/core';
import { IconPlus, IconTrash } from '@tabler/icons-react';
import type { TemplateMeasure, WeightDesign } from '../../../api/types';
import { t } from '../../../i18n';
import { displayUnit, weighedQuantity } from '../../../lib/format';
import './editor.css';
import './Weights.css';

const MOST = 12;
/** As the service takes it. */
const MOST_WEIGHT = 1000;

interface Props {
  weights: readonly WeightDesign[];
  /** What a repetition is measured by when it is compared with this template. */
  measures: readonly TemplateMeasure[];
  onChange: (weights: WeightDesign[]) => void;
}

export function Weights({ weights, measures, onChange }: Props) {
  const set = (index: number, change: Partial<WeightDesign>) =>
    onChange(weights.map((one, place) => (place === index ? { ...one, ...change } : one)));
  const free = measures.filter((one) => weights.every((part) => part.measure !== one.measure));
  const next = free[0];
  return (
    <section className="card stack" aria-labelledby="weights">
      <div>
        <h2 id="weights">{t('design.weights')}</h2>
        <p className="muted">{t('design.weightsLead')}</p>
      </div>
      <ul className="plain-list stop-rows">
        {weights.map((part, index) => {
          const measure = measures.find((one) => one.measure === part.measure);
          return (
            <li key={part.measure} className="stop-limit weight-row">
              <Select
                label={t('design.weightMeasure')}
                description={
                  measure && measure.value !== null
                    ? t('design.weightTemplate', { value: weighedQuantity(measure.value, measure.unit) })
                    : undefined
                }
                inputWrapperOrder={['label', 'input', 'description']}
                searchable
                allowDeselect={false}
                data={[...(measure ? [measure] : []), ...free].map((one) => ({ value: one.measure, label: one.label }))}
                value={part.measure}
                onChange={(value) => value && set(index, { measure: value })}
              />
              <NumberInput
                label={weightLabel(measure)}
                w={170}
                step={0.1}
                min={-MOST_WEIGHT}
                max={MOST_WEIGHT}
                decimalScale={3}
                value={part.weight}
                error={part.weight === 0 && t('design.weightZero')}
                onChange={(value) => set(index, { weight: Number(value) || 0 })}
              />
              <ActionIcon
                size={44}
                variant="default"
                aria-label={t('design.removeWeight', { measure: measure?.label ?? part.measure })}
                onClick={() => onChange(weights.filter((_, place) => place !== index))}
              >
                <IconTrash size={20} aria-hidden />
              </ActionIcon>
            </li>
          );
        })}
      </ul>
      {next && weights.length < MOST && (
        <div>
          <Button
            variant="default"
            leftSection={<IconPlus size={18} aria-hidden />}
            onClick={() => onChange([...weights, { measure: next.measure, weight: 1 }])}
          >
            {t('design.addWeight')}
          </Button>
        </div>
      )}
    </section>
  );
}

/** What one of the measure's own unit counts; a length is weighed by the metre, as the service has it. */
function weightLabel(measure: TemplateMeasure | undefined): string {
  const unit = measure?.unit === 'm' ? 'm' : displayUnit(measure?.unit).suffix.trim();
  if (unit === '°') return t('design.weightDegree');
  return unit ? t('design.weightPer', { unit }) : t('design.weight');
}
