// What only a person knows of a recording: whose it is, of which day, which exercise, and how the patient stood.
import { Group, NumberInput, Select, Switch } from '@mantine/core';
import { useEstimators, useExercises, usePatients } from '../../api/queries';
import { Advanced } from '../../components/forms/Advanced';
import { DateField } from '../../components/forms/DateField';
import { Problem } from '../../components/Feedback';
import { t } from '../../i18n';
import { fullName } from '../../lib/people';

export interface About {
  patientId: string | null;
  day: string;
  exerciseId: string | null;
  estimator: string | null;
  withLegs: boolean;
  knowsPose: boolean;
  pose: [number, number];
  apartCm: number | null;
}

interface Props {
  value: About;
  onChange: (change: Partial<About>) => void;
  needsDay: boolean;
  hasPose: boolean;
  asksFeetApart: boolean;
  /** How orientation is estimated where nobody chose. */
  orientation: string | undefined;
}

export function AboutPart({ value, onChange, needsDay, hasPose, asksFeetApart, orientation }: Props) {
  const patients = usePatients();
  const exercises = useExercises();
  const estimators = useEstimators();
  return (
    <section className="card stack">
      <Select
        label={t('upload.patient')}
        searchable
        maw={480}
        data={(patients.data ?? [])
          .filter((one) => one.may_treat)
          .map((one) => ({ value: one.id, label: fullName(one) }))}
        value={value.patientId}
        onChange={(patientId) => onChange({ patientId })}
      />
      {patients.error && <Problem error={patients.error} />}
      <DateField
        label={t('upload.day')}
        description={t(needsDay ? 'upload.dayHelp' : 'upload.dayOfFile')}
        value={value.day}
        onChange={(day) => onChange({ day })}
      />
      <Select
        label={t('upload.exercise')}
        searchable
        clearable
        maw={480}
        data={(exercises.data ?? []).map((one) => ({ value: one.id, label: one.name }))}
        value={value.exerciseId}
        onChange={(exerciseId) => onChange({ exerciseId })}
      />
      {asksFeetApart && (
        <NumberInput
          label={t('newSession.apart')}
          description={t('newSession.apartHelp')}
          value={value.apartCm ?? ''}
          onChange={(apart) => onChange({ apartCm: typeof apart === 'number' ? apart : null })}
          min={0}
          max={60}
          maw={480}
        />
      )}
      {!asksFeetApart && hasPose && (
        <>
          <Switch
            label={t('upload.withLegs')}
            description={t('upload.withLegsHelp')}
            checked={value.withLegs}
            onChange={(event) => onChange({ withLegs: event.currentTarget.checked })}
          />
          <Switch
            label={t('upload.knowsPose')}
            description={t('upload.knowsPoseHelp')}
            checked={value.knowsPose}
            onChange={(event) => onChange({ knowsPose: event.currentTarget.checked })}
          />
        </>
      )}
      {value.knowsPose && hasPose && (
        <Group>
          <NumberInput
            label={t('upload.poseFrom')}
            suffix=" s"
            min={0}
            w={140}
            value={value.pose[0]}
            onChange={(from) => onChange({ pose: [Number(from) || 0, value.pose[1]] })}
          />
          <NumberInput
            label={t('upload.poseUntil')}
            suffix=" s"
            min={0}
            w={140}
            value={value.pose[1]}
            onChange={(until) => onChange({ pose: [value.pose[0], Number(until) || 0] })}
          />
        </Group>
      )}
      {!asksFeetApart && (
        <Advanced>
          <Select
            label={t('newSession.estimator')}
            maw={480}
            data={(estimators.data ?? []).map((one) => ({ value: one.name, label: one.title }))}
            value={orientation ?? null}
            onChange={(estimator) => onChange({ estimator })}
            description={estimators.data?.find((one) => one.name === orientation)?.description}
          />
        </Advanced>
      )}
    </section>
  );
}
