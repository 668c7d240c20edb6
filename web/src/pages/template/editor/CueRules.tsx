// What is said and when, in plain words; the therapist's own words and cues beside those of the house.
import { ActionIcon, Button, NumberInput, Select, SimpleGrid, Switch, TextInput } from '@mantine/core';
import { IconPlus, IconTrash } from '@tabler/icons-react';
import { useState } from 'react';
import type { CueDesign, PhaseCurve } from '../../../api/types';
import { t } from '../../../i18n';
import { wordsOf } from '../../../i18n/codes';
import { stretches, type Draft } from '../../../lib/assessment/design';
import { number } from '../../../lib/format';
import { cueSays, cueWhen, phaseName, unitOf } from './words';
import './CueRules.css';

/** A sentence that stands in for words of the therapist's own where they cannot be said. */
const STAND_IN = 'guidance.further';

interface Props {
  draft: Draft;
  curves: readonly PhaseCurve[];
  onChange: (change: Partial<Draft>) => void;
}

export function CueRules({ draft, curves, onChange }: Props) {
  const { cues, pace } = draft;
  const set = (index: number, change: Partial<CueDesign>) =>
    onChange({ cues: cues.map((one, place) => (place === index ? { ...one, ...change } : one)) });
  return (
    <section className="card stack" aria-labelledby="cues">
      <div>
        <h2 id="cues">{t('design.cues')}</h2>
        <p className="muted">{t('design.cuesLead')}</p>
      </div>
      <ul className="plain-list cue-rows">
        {cues.map((one, index) => (
          <li key={index} className={one.is_on === false ? 'cue-row cue-row-off' : 'cue-row'}>
            <Switch
              size="lg"
              checked={one.is_on !== false}
              aria-label={t('design.cueOn', { says: cueSays(one) })}
              onChange={(event) => set(index, { is_on: event.currentTarget.checked })}
            />
            <div className="cue-when">
              <span className="strong">{t('design.when', { what: cueWhen(one) })}</span>
              {one.phases && (one.phases[0] > 0 || one.phases[1] < 1) && (
                <span className="muted small">{t('design.inPhase', { phase: phaseOf(draft, one.phases) })}</span>
              )}
            </div>
            <TextInput
              aria-label={t('design.wordsOf', { what: cueWhen(one) })}
              maxLength={120}
              value={one.words ?? ''}
              placeholder={wordsOf(one.sentence)}
              onChange={(event) => set(index, { words: event.currentTarget.value })}
            />
            <Tolerance cue={one} onChange={(tolerance) => set(index, { tolerance })} />
            <ActionIcon
              size={44}
              variant="default"
              aria-label={t('design.removeCue', { what: cueWhen(one) })}
              onClick={() => onChange({ cues: cues.filter((_, place) => place !== index) })}
            >
              <IconTrash size={20} aria-hidden />
            </ActionIcon>
          </li>
        ))}
      </ul>
      <NewCue draft={draft} curves={curves} onAdd={(cue) => onChange({ cues: [...cues, cue] })} />
      <SimpleGrid cols={{ base: 1, sm: 2 }} className="pace">
        <NumberInput
          label={t('design.validShare')}
          min={5}
          max={120}
          suffix=" %"
          value={Math.round(100 * draft.validShare)}
          onChange={(value) => Number(value) >= 5 && onChange({ validShare: Math.min(120, Number(value)) / 100 })}
        />
        <NumberInput
          label={t('design.silence')}
          min={0}
          max={60}
          step={0.5}
          value={pace.silence_s ?? 1.5}
          onChange={(value) => onChange({ pace: { ...pace, silence_s: Math.min(60, Number(value)) } })}
        />
        <NumberInput
          label={t('design.praise')}
          min={0}
          max={100}
          allowDecimal={false}
          value={pace.praise_every ?? 3}
          onChange={(value) => onChange({ pace: { ...pace, praise_every: Math.min(100, Number(value)) } })}
        />
        <NumberInput
          label={t('design.every')}
          min={1}
          max={100}
          allowDecimal={false}
          value={pace.cue_every ?? 1}
          onChange={(value) => onChange({ pace: { ...pace, cue_every: Math.min(100, Math.max(1, Number(value))) } })}
        />
      </SimpleGrid>
    </section>
  );
}

/** The phase in which a cue looks, by its name where there is still such a phase. */
function phaseOf(draft: Draft, [first, last]: readonly [number, number]): string {
  const index = stretches(draft.phases).findIndex(
    ([start, end]) => Math.abs(start - first) < 0.02 && Math.abs(end - last) < 0.02,
  );
  return index >= 0 ? phaseName(draft.phases, index) : `${number(100 * first)}–${number(100 * last)} %`;
}

function Tolerance({ cue, onChange }: { cue: CueDesign; onChange: (value: number) => void }) {
  if (cue.tolerance == null) return <span className="muted small cue-band">{t('design.legendBand')}</span>;
  const isAngle = cue.quantity === 'at_equal' || (cue.quantity === 'deviation' && unitOf(cue.channel ?? '') === 'rad');
  const [factor, suffix, digits] = isAngle
    ? [180 / Math.PI, '°', 0]
    : cue.quantity === 'deviation'
      ? [100, ' cm', 1]
      : cue.quantity === 'range'
        ? [100, ' %', 0]
        : [1, ' ×', 2];
  return (
    <NumberInput
      aria-label={t('design.limitOf', { what: cueWhen(cue) })}
      suffix={suffix}
      decimalScale={digits}
      step={digits === 2 ? 0.05 : digits === 1 ? 0.5 : 1}
      min={digits === 2 ? 1 : 0.5}
      value={Number((cue.tolerance * factor).toFixed(digits))}
      onChange={(value) => Number(value) > 0 && onChange(Number(value) / factor)}
    />
  );
}

function NewCue({
  draft,
  curves,
  onAdd,
}: {
  draft: Draft;
  curves: readonly PhaseCurve[];
  onAdd: (cue: CueDesign) => void;
}) {
  const [isOpen, setIsOpen] = useState(false);
  const [channel, setChannel] = useState<string | null>(null);
  const [side, setSide] = useState<'above' | 'both' | 'below'>('both');
  const [phase, setPhase] = useState('all');
  const [words, setWords] = useState('');
  const chosen = channel ?? curves[0]?.channel ?? '';
  if (!isOpen)
    return (
      <div>
        <Button variant="default" leftSection={<IconPlus size={18} aria-hidden />} onClick={() => setIsOpen(true)}>
          {t('design.addCue')}
        </Button>
      </div>
    );
  const add = () => {
    const stretch = phase === 'all' ? undefined : stretches(draft.phases)[Number(phase)];
    onAdd({
      quantity: 'deviation',
      sentence: STAND_IN,
      words: words.trim(),
      channel: chosen,
      side,
      phases: stretch ?? [0, 1],
      tolerance: null,
      hold_s: 0.25,
      priority: 1,
      is_on: true,
    });
    setIsOpen(false);
    setWords('');
  };
  return (
    <div className="new-cue">
      <Select
        label={t('design.newCueCurve')}
        data={curves.map((one) => ({ value: one.channel, label: one.label }))}
        value={chosen}
        onChange={(value) => value && setChannel(value)}
        data-autofocus
      />
      <Select
        label={t('design.newCueSide')}
        data={(['above', 'below', 'both'] as const).map((value) => ({ value, label: t(`design.side.${value}`) }))}
        value={side}
        onChange={(value) => setSide((value as typeof side | null) ?? 'both')}
      />
      {draft.phases.length > 1 && (
        <Select
          label={t('design.newCuePhase')}
          data={[
            { value: 'all', label: t('design.whole') },
            ...draft.phases.map((_, index) => ({ value: String(index), label: phaseName(draft.phases, index) })),
          ]}
          value={phase}
          onChange={(value) => setPhase(value ?? 'all')}
        />
      )}
      <TextInput
        className="new-cue-words"
        label={t('design.newCueWords')}
        placeholder={t('design.newCueExample')}
        maxLength={120}
        value={words}
        onChange={(event) => setWords(event.currentTarget.value)}
      />
      <div className="new-cue-deeds">
        <Button variant="default" onClick={() => setIsOpen(false)}>
          {t('action.cancel')}
        </Button>
        <Button disabled={!words.trim()} onClick={add}>
          {t('design.addCue')}
        </Button>
      </div>
    </div>
  );
}
