// What is prescribed: exercise and template, dose, days and times, how strictly it is judged, what stops it, until when.
import { ActionIcon, Button, Chip, Group, NumberInput, Select, SimpleGrid, TextInput } from '@mantine/core';
import { IconPlus, IconTrash } from '@tabler/icons-react';
import { useMemo, useState, type FormEvent } from 'react';
import {
  useChangePrescription,
  useExercises,
  usePrescribe,
  usePrescriptions,
  useTemplates,
  useTemplateVersion,
} from '../../api/queries';
import type { Exercise, Patient, PhaseCurve, Prescription, StopDesign, TemplateVersionDetail } from '../../api/types';
import { DateField, isDateOrEmpty } from '../../components/forms/DateField';
import { Notice, Problem } from '../../components/Feedback';
import { t } from '../../i18n';
import { brokenBy } from '../../lib/assessment/limits';
import { DAYS, dayName } from '../../lib/assessment/practice';
import { isWalk, exerciseOf, primaryAngles } from '../../lib/exercises';
import { LimitRows } from '../template/editor/StopRules';

const NO_TEMPLATE = 'none';
const MOST_TIMES = 4;
const FIRST_TIME = '09:00';
/** Limits of the factor on the band, in percent. */
const NARROWEST = 50;
const WIDEST = 300;

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
  const [exerciseId, setExerciseId] = useState<string | null>(prescription?.exercise_id ?? null);
  const [templateId, setTemplateId] = useState<string | null>(
    prescription ? (prescription.template_id ?? NO_TEMPLATE) : null,
  );
  const [repetitions, setRepetitions] = useState(prescription?.repetitions ?? 10);
  const [sets, setSets] = useState(prescription?.sets ?? 1);
  const [perWeek, setPerWeek] = useState(prescription?.times_per_week ?? 5);
  const [days, setDays] = useState<string[]>(prescription?.days.map(String) ?? []);
  const [times, setTimes] = useState<string[]>(prescription?.times ?? []);
  const [percent, setPercent] = useState<number | string>(Math.round(100 * (prescription?.tolerance_scale ?? 1)));
  const [stops, setStops] = useState<StopDesign[]>(prescription?.stops ?? []);
  const [question, setQuestion] = useState(prescription?.question ?? '');
  const endDay = prescription?.ends_at ? localDay(prescription.ends_at) : '';
  const [endsAt, setEndsAt] = useState(endDay);
  const templates = useTemplates(exerciseId, patient.id, exerciseId !== null);
  const prescribe = usePrescribe(patient.id);
  const change = useChangePrescription(patient.id);
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
    const wanted = {
      template_id: chosen === NO_TEMPLATE ? null : chosen,
      repetitions: isWalked ? 1 : repetitions,
      sets: isWalked ? 1 : sets,
      times_per_week: perWeek,
      days: days.map(Number),
      times: days.length ? times.filter(Boolean) : [],
      tolerance_scale: hasTemplate ? Math.min(WIDEST, Math.max(NARROWEST, Number(percent) || 100)) / 100 : 1,
      stops: hasTemplate && !isWalked ? stops : [],
      question,
      // An end that was not touched keeps its moment.
      ends_at: !endsAt
        ? null
        : prescription && endsAt === endDay
          ? prescription.ends_at
          : new Date(`${endsAt}T23:59:59`).toISOString(),
    };
    if (prescription)
      change.mutate(
        { prescriptionId: prescription.id, number: prescription.number ?? 1, ...wanted },
        { onSuccess: onDone },
      );
    else prescribe.mutate({ exercise_id: exerciseId, ...wanted }, { onSuccess: onDone });
  };
  return (
    <form className="stack" onSubmit={submit}>
      {(prescribe.error ?? change.error) && <Problem error={prescribe.error ?? change.error} />}
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
          setExerciseId(value);
          setTemplateId(null);
          setStops([]);
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
          onChange={setTemplateId}
        />
      )}
      {!isWalked && (
        <SimpleGrid cols={2}>
          <NumberInput
            label={t('prescription.repetitionsLabel')}
            min={1}
            max={200}
            value={repetitions}
            onChange={(value) => setRepetitions(Number(value) || 1)}
          />
          <NumberInput
            label={t('prescription.setsLabel')}
            min={1}
            max={20}
            value={sets}
            onChange={(value) => setSets(Number(value) || 1)}
          />
        </SimpleGrid>
      )}
      <Schedule
        days={days}
        onDays={setDays}
        times={times}
        onTimes={setTimes}
        perWeek={perWeek}
        onPerWeek={setPerWeek}
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
            onChange={setPercent}
          />
          {!isWalked && <Limits exercise={exercise} curves={curves} left={left} stops={stops} onChange={setStops} />}
        </>
      )}
      <TextInput
        label={t('prescription.question')}
        description={t('prescription.questionHelp')}
        maxLength={200}
        value={question}
        onChange={(event) => setQuestion(event.currentTarget.value)}
      />
      <DateField
        label={t('prescription.until')}
        description={t('prescription.untilHelp')}
        value={endsAt}
        onChange={setEndsAt}
      />
      <Group justify="flex-end">
        <Button variant="default" onClick={onDone}>
          {t('action.cancel')}
        </Button>
        <Button type="submit" disabled={!exerciseId || isBroken} loading={prescribe.isPending || change.isPending}>
          {t(prescription ? 'prescription.saveChange' : 'prescription.prescribe')}
        </Button>
      </Group>
    </form>
  );
}

function Schedule({
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

/** The day of a moment by the clocks of this browser, as a field of a form has it. */
function localDay(moment: string): string {
  const at = new Date(moment);
  const two = (value: number) => String(value).padStart(2, '0');
  return `${at.getFullYear()}-${two(at.getMonth() + 1)}-${two(at.getDate())}`;
}

/** What the recording of a template did, for its limits; nothing while that is not known. */
function recordedOf(version: TemplateVersionDetail | undefined) {
  return {
    curves: version?.content.curves ?? [],
    left: new Set(version?.content.repetitions.flatMap((one, index) => (one.is_kept ? [] : [index])) ?? []),
  };
}

function Limits({
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
