// What stops the exercise, in plain words: limits of angles, counts, time, and wrong ones in a row.
import { ActionIcon, Button, NumberInput, SegmentedControl, Select, Switch } from '@mantine/core';
import { IconPlus, IconTrash } from '@tabler/icons-react';
import type { PhaseCurve, StopDesign } from '../../../api/types';
import { t } from '../../../i18n';
import { channelLabel } from '../../../lib/channels';
import { brokenBy, proposedLimit } from '../../../lib/assessment/limits';
import { number, quantity } from '../../../lib/format';
import '../../../styles/design.css';
import { unitOf } from './words';
import './editor.css';
import './StopRules.css';

const COUNTS = ['valid_count', 'attempt_count', 'time', 'wrong_in_a_row'] as const;
const START: Record<(typeof COUNTS)[number], number> = {
  valid_count: 10,
  attempt_count: 15,
  time: 300,
  wrong_in_a_row: 3,
};
const RANGE_HOLD_S = 0.05;
const MINUTE_S = 60;
const NINETY = Math.PI / 2;

interface Props {
  stops: readonly StopDesign[];
  /** Of the template, by which limits are proposed and refused; none: nothing is known of the movement. */
  curves: readonly PhaseCurve[];
  /** Repetitions of its recording that do not count. */
  left: ReadonlySet<number>;
  /** Channels that may have a limit. */
  channels: readonly string[];
  primary: string;
  onChange: (stops: StopDesign[]) => void;
}

export function StopRules({ stops, curves, left, channels, primary, onChange }: Props) {
  const set = (index: number, change: Partial<StopDesign>) =>
    onChange(stops.map((one, place) => (place === index ? { ...one, ...change } : one)));
  const hold = (kind: StopDesign['kind']) => quantity(stops.find((one) => one.kind === kind)?.hold_s ?? 0, 's');
  return (
    <section className="card stack" aria-labelledby="stops">
      <div>
        <h2 id="stops">{t('design.stops')}</h2>
        <p className="muted">{t('design.stopsLead')}</p>
      </div>
      <LimitRows stops={stops} curves={curves} left={left} channels={channels} primary={primary} onChange={onChange} />
      <ul className="plain-list stop-rows">
        {COUNTS.map((kind) => {
          const index = stops.findIndex((one) => one.kind === kind);
          const rule = stops[index];
          const factor = kind === 'time' ? 1 / MINUTE_S : 1;
          return (
            <li key={kind} className="stop-count">
              <Switch
                size="md"
                label={t(`design.stop.${kind}`)}
                checked={rule !== undefined}
                onChange={(event) =>
                  onChange(
                    event.currentTarget.checked
                      ? [...stops, { kind, limit: START[kind], hold_s: 0 }]
                      : stops.filter((one) => one.kind !== kind),
                  )
                }
              />
              {rule && (
                <NumberInput
                  w={110}
                  min={1}
                  max={kind === 'time' ? 120 : 500}
                  aria-label={t('design.stopValue', { rule: t(`design.stop.${kind}`) })}
                  value={Math.round((rule.limit ?? 0) * factor * 10) / 10}
                  onChange={(value) => Number(value) > 0 && set(index, { limit: Number(value) / factor })}
                />
              )}
            </li>
          );
        })}
      </ul>
      <p className="muted small">{t('design.stopAlways', { lost: hold('lost'), unsure: hold('unsure') })}</p>
    </section>
  );
}

/** Limits of angles, each with its side and value; other stop rules stay as they are. */
export function LimitRows({ stops, curves, left, channels, primary, onChange }: Props) {
  // Another angle or side has another limit: the value of the one before says nothing of it.
  const proposed = (channel: string, side: 'above' | 'below') =>
    proposedLimit(
      curves.find((one) => one.channel === channel),
      side,
      left,
    ) ?? NINETY;
  const set = (index: number, change: Partial<StopDesign>) =>
    onChange(stops.map((one, place) => (place === index ? { ...one, ...change } : one)));
  return (
    <>
      <ul className="plain-list stop-rows">
        {stops.map((one, index) =>
          one.kind === 'limit' ? (
            <li key={index} className="stop-limit">
              <Select
                label={t('design.limitAngle')}
                data={channels.map((value) => ({ value, label: channelLabel(value).text }))}
                value={one.channel ?? ''}
                onChange={(value) =>
                  value && set(index, { channel: value, limit: proposed(value, one.side ?? 'above') })
                }
              />
              <div>
                <span className="field-label" id={`stop-side-${index}`}>
                  {t('design.limitSide')}
                </span>
                <SegmentedControl
                  size="md"
                  aria-labelledby={`stop-side-${index}`}
                  data={[
                    { value: 'above', label: t('design.limitAbove') },
                    { value: 'below', label: t('design.limitBelow') },
                  ]}
                  value={one.side ?? 'above'}
                  onChange={(value) => {
                    const side = value === 'below' ? 'below' : 'above';
                    set(index, { side, limit: proposed(one.channel ?? '', side) });
                  }}
                />
              </div>
              <LimitValue
                channel={one.channel ?? ''}
                side={one.side ?? 'above'}
                broken={brokenBy(one, curves, left)}
                value={one.limit ?? 0}
                onChange={(limit) => set(index, { limit })}
              />
              <ActionIcon
                size={44}
                variant="default"
                aria-label={t('design.removeLimit', { curve: channelLabel(one.channel ?? '').text })}
                onClick={() => onChange(stops.filter((_, place) => place !== index))}
              >
                <IconTrash size={20} aria-hidden />
              </ActionIcon>
            </li>
          ) : null,
        )}
      </ul>
      <div>
        <Button
          variant="default"
          leftSection={<IconPlus size={18} aria-hidden />}
          onClick={() =>
            onChange([
              {
                kind: 'limit',
                channel: primary,
                limit: proposed(primary, 'above'),
                side: 'above',
                hold_s: RANGE_HOLD_S,
              },
              ...stops,
            ])
          }
        >
          {t('design.addLimit')}
        </Button>
      </div>
    </>
  );
}

/** As it is read, rounded to the side that keeps the recording. */
function amount(channel: string, value: number, to: 'above' | 'below' | 'plain'): string {
  const isLength = unitOf(channel) === 'm';
  const shown = value * (isLength ? 100 : 180 / Math.PI);
  const whole = { above: Math.ceil, below: Math.floor, plain: Math.round }[to](Number(shown.toFixed(6)));
  return `${number(whole)}${isLength ? '\u00a0cm' : '°'}`;
}

function LimitValue({
  channel,
  side,
  broken,
  value,
  onChange,
}: {
  channel: string;
  side: 'above' | 'below';
  broken: { value: number; least: number } | null;
  value: number;
  onChange: (value: number) => void;
}) {
  const isLength = unitOf(channel) === 'm';
  const factor = isLength ? 100 : 180 / Math.PI;
  return (
    <NumberInput
      label={t(isLength ? 'design.limitValueM' : 'design.limitValue')}
      w={broken ? 280 : 150}
      error={
        broken &&
        t(`design.limitBroken.${side}`, {
          value: amount(channel, broken.value, 'plain'),
          least: amount(channel, broken.least, side),
        })
      }
      suffix={isLength ? ' cm' : '°'}
      decimalScale={isLength ? 1 : 0}
      value={Number((value * factor).toFixed(isLength ? 1 : 0))}
      onChange={(typed) => typeof typed === 'number' && onChange(typed / factor)}
    />
  );
}
