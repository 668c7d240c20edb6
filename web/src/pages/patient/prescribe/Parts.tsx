// Parts of the form of a prescription: its days and times, and the limits for this patient.
import { ActionIcon, Button, Chip, Group, NumberInput, TextInput } from '@mantine/core';
import { IconPlus, IconTrash } from '@tabler/icons-react';
import type { Exercise, PhaseCurve, StopDesign } from '../../../api/types';
import { t } from '../../../i18n';
import { DAYS, dayName } from '../../../lib/assessment/practice';
import { primaryAngles } from '../../../lib/exercises';
import { LimitRows } from '../../template/editor/StopRules';
import './Parts.css';

const MOST_TIMES = 4;
const FIRST_TIME = '09:00';

export function Schedule({
  days,
  onDays,
  times,
  onTimes,
  perWeek,
  onPerWeek,
}: {
  days: string[];
  onDays: (days: string[]) => void;
  times: string[];
  onTimes: (times: string[]) => void;
  perWeek: number;
  onPerWeek: (count: number) => void;
}) {
  return (
    <fieldset className="fieldset">
      <legend>{t('prescription.days')}</legend>
      <p className="muted small">{t('prescription.daysHelp')}</p>
      <Chip.Group multiple value={days} onChange={onDays}>
        <div className="day-chips">
          {DAYS.map((one) => (
            <Chip key={one} value={String(one)} size="md" radius="md">
              {dayName(one, 'short')}
            </Chip>
          ))}
        </div>
      </Chip.Group>
      {days.length === 0 ? (
        <NumberInput
          mt={14}
          maw={200}
          label={t('prescription.perWeekLabel')}
          min={1}
          max={28}
          value={perWeek}
          onChange={(value) => onPerWeek(Number(value) || 1)}
        />
      ) : (
        <>
          <Group gap={10} mt={14} align="end">
            {times.map((one, index) => (
              <Group key={index} gap={4} align="end">
                <TextInput
                  type="time"
                  required
                  withAsterisk={false}
                  label={t('prescription.timeNumber', { number: index + 1 })}
                  value={one}
                  onChange={(event) =>
                    onTimes(times.map((before, place) => (place === index ? event.currentTarget.value : before)))
                  }
                />
                <ActionIcon
                  size={44}
                  variant="default"
                  aria-label={t('prescription.removeTime', { number: index + 1 })}
                  onClick={() => onTimes(times.filter((_, place) => place !== index))}
                >
                  <IconTrash size={20} aria-hidden />
                </ActionIcon>
              </Group>
            ))}
            {times.length < MOST_TIMES && (
              <Button
                variant="default"
                leftSection={<IconPlus size={18} aria-hidden />}
                onClick={() => onTimes([...times, times.length ? '' : FIRST_TIME])}
              >
                {t('prescription.addTime')}
              </Button>
            )}
          </Group>
          <p className="small strong">
            {t('prescription.inAll', { count: days.length * Math.max(1, new Set(times.filter(Boolean)).size) })}
          </p>
        </>
      )}
    </fieldset>
  );
}

export function Limits({
  exercise,
  curves,
  left,
  stops,
  onChange,
}: {
  exercise: Exercise;
  curves: readonly PhaseCurve[];
  left: ReadonlySet<number>;
  stops: StopDesign[];
  onChange: (stops: StopDesign[]) => void;
}) {
  const all = primaryAngles(exercise.side ?? 'right');
  // A limit of what the template does not measure could not be watched.
  const measured = all.filter((one) => curves.some(({ channel }) => channel === one));
  const angles = measured.length ? measured : all;
  return (
    <fieldset className="fieldset">
      <legend>{t('prescription.stops')}</legend>
      <p className="muted small">{t('prescription.stopsHelp')}</p>
      <LimitRows
        stops={stops}
        curves={curves}
        left={left}
        channels={angles}
        primary={exercise.primary_angle || (angles[0] ?? '')}
        onChange={onChange}
      />
    </fieldset>
  );
}
