// The same phases and limits as on the curve, as a table of fields: for those who rather type than drag.
import { ActionIcon, Button, Checkbox, NumberInput, TextInput } from '@mantine/core';
import { IconArrowsSplit2, IconTrash, IconWand } from '@tabler/icons-react';
import type { PhaseCurve } from '../../../api/types';
import { t } from '../../../i18n';
import { bandsFor, MOST_PHASES, SHORTEST, stretches, type Draft, type Edge } from '../../../lib/assessment/design';
import { displayUnit, number } from '../../../lib/format';
import { handlesOf, type Handle } from './geometry';
import { phaseName } from './words';
import './PhaseTable.css';

interface Props {
  curve: PhaseCurve;
  draft: Draft;
  selected: number;
  onSelect: (phase: number) => void;
  onBand: (phase: number, edge: Edge, factor: number | null) => void;
  onName: (phase: number, name: string) => void;
  onSplit: (phase: number) => void;
  onRemove: (phase: number) => void;
  /** Without, there is nothing to suggest. */
  onSuggest?: () => void;
}

export function PhaseTable({ curve, draft, selected, onSelect, onBand, onName, onSplit, onRemove, onSuggest }: Props) {
  const handles = handlesOf(curve, draft);
  const isPlain = draft.watched.includes(curve.channel);
  return (
    <section aria-labelledby="phases">
      <div className="card-head">
        <h3 id="phases">{t('design.phases')}</h3>
        {onSuggest && draft.phases.length === 1 && !draft.phases[0]?.name && (
          <Button className="end" leftSection={<IconWand size={18} aria-hidden />} onClick={onSuggest}>
            {t('design.suggest')}
          </Button>
        )}
      </div>
      <p className="muted small">{t('design.phasesHelp', { curve: curve.label })}</p>
      <ol className="plain-list phase-rows">
        {stretches(draft.phases).map(([start, end], index) => (
          <li
            key={index}
            className={index === selected ? 'phase-row phase-row-on' : 'phase-row'}
            onFocusCapture={() => onSelect(index)}
          >
            <TextInput
              label={t('design.name')}
              aria-label={t('design.nameOf', { number: index + 1 })}
              placeholder={phaseName(draft.phases, index)}
              maxLength={40}
              value={draft.phases[index]?.name ?? ''}
              onChange={(event) => onName(index, event.currentTarget.value)}
              description={t('design.from', { from: number(100 * start), to: number(100 * end) })}
              inputWrapperOrder={['label', 'input', 'description']}
            />
            {(['above', 'below'] as const).map((edge) => (
              <Limit
                key={edge}
                handle={handles.find((one) => one.phase === index && one.edge === edge)}
                isFree={bandsFor(draft, curve.channel)[index]?.[edge] === null}
                unit={curve.unit}
                phase={phaseName(draft.phases, index)}
                isDisabled={isPlain}
                edge={edge}
                onFactor={(factor) => onBand(index, edge, factor)}
              />
            ))}
            <span className="phase-deeds">
              <ActionIcon
                size={44}
                variant="default"
                aria-label={t('design.splitOf', { phase: phaseName(draft.phases, index) })}
                title={t('design.split')}
                disabled={end - start < 2 * SHORTEST || draft.phases.length >= MOST_PHASES}
                onClick={() => onSplit(index)}
              >
                <IconArrowsSplit2 size={20} aria-hidden />
              </ActionIcon>
              {draft.phases.length > 1 && (
                <ActionIcon
                  size={44}
                  variant="default"
                  aria-label={t('design.removeOf', { phase: phaseName(draft.phases, index) })}
                  title={t('design.remove')}
                  onClick={() => onRemove(index)}
                >
                  <IconTrash size={20} aria-hidden />
                </ActionIcon>
              )}
            </span>
          </li>
        ))}
      </ol>
    </section>
  );
}

function Limit({
  handle,
  isFree,
  unit,
  phase,
  edge,
  isDisabled,
  onFactor,
}: {
  handle: Handle | undefined;
  isFree: boolean;
  unit: string;
  phase: string;
  edge: Edge;
  isDisabled: boolean;
  onFactor: (factor: number | null) => void;
}) {
  const shown = displayUnit(unit);
  const isLength = unit === 'm';
  const isSpeed = unit === 'm/s';
  const unitWord = t(isLength ? 'design.unitCm' : isSpeed ? 'design.unitSpeed' : 'design.unitDegrees');
  const decimals = isSpeed ? 2 : 1;
  const away = handle && handle.factor !== null ? handle.factor * handle.width * shown.factor : '';
  return (
    <div className="limit">
      <NumberInput
        label={t(edge === 'above' ? 'design.above' : 'design.below')}
        aria-label={t(edge === 'above' ? 'design.aboveOf' : 'design.belowOf', { phase, unit: unitWord })}
        suffix={shown.suffix}
        min={0}
        step={isSpeed ? 0.05 : isLength ? 0.5 : 1}
        decimalScale={decimals}
        allowNegative={false}
        clampBehavior="none"
        disabled={isDisabled || isFree || !handle}
        placeholder={isFree ? t('design.free') : undefined}
        value={away === '' ? '' : Number(away.toFixed(decimals))}
        onChange={(value) => {
          if (handle && typeof value === 'number' && Math.abs(value - Number(away)) > 0.5 * 10 ** -decimals)
            onFactor(value / shown.factor / handle.width);
        }}
      />
      <Checkbox
        label={t('design.free')}
        aria-label={t(edge === 'above' ? 'design.freeAboveOf' : 'design.freeBelowOf', { phase })}
        checked={isFree}
        disabled={isDisabled || !handle}
        onChange={(event) => onFactor(event.currentTarget.checked ? null : 1)}
      />
    </div>
  );
}
