// What is prescribed: exercise and template, dose, days and times, how strictly it is judged, what stops it, until when.
import { Button, Group, NumberInput, Select, SimpleGrid, TextInput } from '@mantine/core';
import { useMemo, useState, type FormEvent } from 'react';
import { ApiError } from '../../../api/client';
import { useChangePrescription, usePrescribe } from '../../../api/changes';
import { useExercises, usePrescriptions, useTemplates, useTemplateVersion } from '../../../api/queries';
import type { Patient, Prescription, TemplateVersionDetail } from '../../../api/types';
import { DateField, isDateOrEmpty } from '../../../components/forms/DateField';
import { useUnsaved } from '../../../components/forms/useUnsaved';
import { Notice, Problem } from '../../../components/Feedback';
import { t } from '../../../i18n';
import { brokenBy } from '../../../lib/assessment/limits';
import { isSame } from '../../../lib/editing/merge';
import { isWalk, exerciseOf } from '../../../lib/exercises';
import { MergePrescription } from './MergePrescription';
import { Limits, Schedule } from './Parts';
import { NARROWEST, NO_TEMPLATE, valuesOf, wantedOf, WIDEST } from './values';

/** Whether the service refused a change because somebody else changed it since it was opened. */
function isChangedMeanwhile(error: unknown): boolean {
  return error instanceof ApiError && error.status === 409 && 'changed_at' in error.details;
}

/** Without a prescription a new one; with one, its exercise stays and everything else may change. */
export function PrescribeForm({
  patient,
  prescription,
  onDone,
}: {
  patient: Patient;
  prescription?: Prescription;
  onDone: () => void;
}) {
  const exercises = useExercises();
  const present = usePrescriptions(patient.id);
  // The state that is changed, as it was opened: the list behind the dialog is read anew meanwhile.
  const [base, setBase] = useState(prescription);
  const [isJoined, setJoined] = useState(false);
  const [values, setValues] = useState(() => valuesOf(prescription));
  const set = (some: Partial<typeof values>) => setValues((now) => ({ ...now, ...some }));
  const { exerciseId, templateId, repetitions, sets, schedule, percent, stops, question, endsAt } = values;
  const isChanged = !isSame(values, valuesOf(base));
  const { guard, release } = useUnsaved({
    object: `prescription:${patient.id}:${prescription?.id ?? 'new'}`,
    // With the state that it changes: a change that somebody saved meanwhile is found when this is saved.
    value: { values, base },
    isChanged,
    onRestore: (stored) => {
      setBase(stored.base);
      setValues(stored.values);
    },
  });
  const templates = useTemplates(exerciseId, patient.id, exerciseId !== null);
  const prescribe = usePrescribe(patient.id, release);
  const change = useChangePrescription(patient.id, release);
  const choices = templates.data ?? [];
  const exercise = exercises.data?.find((one) => one.id === exerciseId);
  const isWalked = isWalk(exerciseOf(exercises.data, exerciseId)?.movement);
  const chosen = templateId ?? choices[0]?.id ?? NO_TEMPLATE;
  const hasTemplate = chosen !== NO_TEMPLATE;
  const version = useTemplateVersion(choices.find((one) => one.id === chosen)?.versions[0]?.id ?? null).data;
  const { curves, left } = useMemo(() => recordedOf(version), [version]);
  const isBroken = hasTemplate && !isWalked && stops.some((one) => brokenBy(one, curves, left));
  const submit = (event: FormEvent) => {
    event.preventDefault();
    if (!exerciseId || !isDateOrEmpty(endsAt)) return;
    const wanted = wantedOf(values, chosen, isWalked, base);
    if (base) change.mutate({ prescriptionId: base.id, number: base.number ?? 1, ...wanted }, { onSuccess: onDone });
    else prescribe.mutate({ exercise_id: exerciseId, ...wanted }, { onSuccess: onDone });
  };
  const isRefused = isChangedMeanwhile(change.error);
  const stored = present.data?.find((one) => one.id === base?.id);
  const newest = isRefused && base && stored && (stored.number ?? 1) > (base.number ?? 1) ? stored : undefined;
  return (
    <form className="stack" onSubmit={submit}>
      {guard}
      {(prescribe.error ?? change.error) && !newest && <Problem error={prescribe.error ?? change.error} />}
      {exercises.error && <Problem error={exercises.error} />}
      <Select
        label={t('prescription.exercise')}
        placeholder={t('prescription.chooseExercise')}
        required
        withAsterisk={false}
        searchable
        disabled={prescription !== undefined}
        openOnFocus={false}
        data={(exercises.data ?? []).map((one) => ({ value: one.id, label: one.name }))}
        value={exerciseId}
        onChange={(value) => {
          set({ exerciseId: value, templateId: null, stops: [] });
        }}
        data-autofocus
      />
      {present.data?.some((one) => one.exercise_id === exerciseId && one.id !== prescription?.id) && (
        <Notice>{t('prescription.twice')}</Notice>
      )}
      {exerciseId && templates.data && (!isWalked || choices.length > 0) && (
        <Select
          label={t('prescription.template')}
          description={t(
            isWalked
              ? 'prescription.walkTemplateHelp'
              : choices.length
                ? 'prescription.templateHelp'
                : 'prescription.noTemplateHelp',
          )}
          data={[
            ...choices.map((one) => ({ value: one.id, label: one.name })),
            { value: NO_TEMPLATE, label: t('prescription.without') },
          ]}
          value={chosen}
          onChange={(value) => set({ templateId: value })}
        />
      )}
      {!isWalked && (
        <SimpleGrid cols={2}>
          <NumberInput
            label={t('prescription.repetitionsLabel')}
            min={1}
            max={200}
            value={repetitions}
            onChange={(value) => set({ repetitions: Number(value) || 1 })}
          />
          <NumberInput
            label={t('prescription.setsLabel')}
            min={1}
            max={20}
            value={sets}
            onChange={(value) => set({ sets: Number(value) || 1 })}
          />
        </SimpleGrid>
      )}
      <Schedule
        days={schedule.days}
        onDays={(days) => set({ schedule: { ...schedule, days } })}
        times={schedule.times}
        onTimes={(times) => set({ schedule: { ...schedule, times } })}
        perWeek={schedule.perWeek}
        onPerWeek={(perWeek) => set({ schedule: { ...schedule, perWeek } })}
      />
      {hasTemplate && exercise && (
        <>
          <NumberInput
            maw={260}
            label={t('prescription.tolerance')}
            description={t('prescription.toleranceHelp')}
            min={NARROWEST}
            max={WIDEST}
            step={10}
            suffix=" %"
            allowDecimal={false}
            value={percent}
            onChange={(value) => set({ percent: value })}
          />
          {!isWalked && (
            <Limits
              exercise={exercise}
              curves={curves}
              left={left}
              stops={stops}
              onChange={(value) => set({ stops: value })}
            />
          )}
        </>
      )}
      <TextInput
        label={t('prescription.question')}
        description={t('prescription.questionHelp')}
        maxLength={200}
        value={question}
        onChange={(event) => set({ question: event.currentTarget.value })}
      />
      <DateField
        label={t('prescription.until')}
        description={t('prescription.untilHelp')}
        value={endsAt}
        onChange={(value) => set({ endsAt: value })}
      />
      {newest && base && (
        <MergePrescription
          base={base}
          newest={newest}
          values={values}
          templates={choices}
          onTake={(merged) => {
            setBase(newest);
            setJoined(true);
            setValues(merged);
            change.reset();
          }}
        />
      )}
      {isJoined && !newest && <Notice>{t('meanwhile.taken')}</Notice>}
      <Group justify="flex-end">
        <Button
          variant="default"
          onClick={() => {
            release();
            onDone();
          }}
        >
          {t('action.cancel')}
        </Button>
        <Button
          type="submit"
          disabled={!exerciseId || isBroken || newest !== undefined}
          loading={prescribe.isPending || change.isPending}
        >
          {t(prescription ? 'prescription.saveChange' : 'prescription.prescribe')}
        </Button>
      </Group>
    </form>
  );
}

/** What the recording of a template did, for its limits; nothing while that is not known. */
function recordedOf(version: TemplateVersionDetail | undefined) {
  return {
    curves: version?.content.curves ?? [],
    left: new Set(version?.content.repetitions.flatMap((one, index) => (one.is_kept ? [] : [index])) ?? []),
  };
}
