// What stops the exercise, in plain words: limits of angles, counts, time, and wrong ones in a row.
import { ActionIcon, Button, NumberInput, SegmentedControl, Select, Switch } from '@mantine/core';
import { IconPlus, IconTrash } from '@tabler/icons-react';
import type { StopDesign } from '../../../api/types';
import { t } from '../../../i18n';
import { channelLabel } from '../../../lib/channels';
import { quantity } from '../../../lib/format';
import '../../../styles/design.css';
import { unitOf } from './words';

const COUNTS = ['valid_count', 'attempt_count', 'time', 'wrong_in_a_row'] as const;
const START: Record<(typeof COUNTS)[number], number> = {
  valid_count: 10,
  attempt_count: 15,
  time: 300,
  wrong_in_a_row: 3,
};
const RANGE_HOLD_S = 0.05;
const MINUTE_S = 60;

interface Props {
  stops: readonly StopDesign[];
  /** Channels that may have a limit. */
  channels: readonly string[];
  primary: string;
  onChange: (stops: StopDesign[]) => void;
}

export function StopRules({ stops, channels, primary, onChange }: Props) {
  const set = (index: number, change: Partial<StopDesign>) =>
    onChange(stops.map((one, place) => (place === index ? { ...one, ...change } : one)));
  const hold = (kind: StopDesign['kind']) => quantity(stops.find((one) => one.kind === kind)?.hold_s ?? 0, 's');
  return (
    <section className="card stack" aria-labelledby="stops">
      <div>
        <h2 id="stops">{t('design.stops')}</h2>
        <p className="muted">{t('design.stopsLead')}</p>
      </div>
      <LimitRows stops={stops} channels={channels} primary={primary} onChange={onChange} />
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
export function LimitRows({ stops, channels, primary, onChange }: Props) {
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
                onChange={(value) => value && set(index, { channel: value })}
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
                  onChange={(value) => set(index, { side: value === 'below' ? 'below' : 'above' })}
                />
              </div>
              <LimitValue
                channel={one.channel ?? ''}
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
              { kind: 'limit', channel: primary, limit: Math.PI / 2, side: 'above', hold_s: RANGE_HOLD_S },
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

function LimitValue({
  channel,
  value,
  onChange,
}: {
  channel: string;
  value: number;
  onChange: (value: number) => void;
}) {
  const isLength = unitOf(channel) === 'm';
  const factor = isLength ? 100 : 180 / Math.PI;
  return (
    <NumberInput
      label={t(isLength ? 'design.limitValueM' : 'design.limitValue')}
      w={150}
      suffix={isLength ? ' cm' : '°'}
      decimalScale={isLength ? 1 : 0}
      value={Number((value * factor).toFixed(isLength ? 1 : 0))}
      onChange={(typed) => typeof typed === 'number' && onChange(typed / factor)}
    />
  );
}
