// What is prescribed: exercise and template, dose, days and times, how strictly it is judged, what stops it, until when.
import { ActionIcon, Button, Chip, Group, NumberInput, Select, SimpleGrid, TextInput } from '@mantine/core';
import { IconPlus, IconTrash } from '@tabler/icons-react';
import { useState, type FormEvent } from 'react';
import { useExercises, usePrescribe, usePrescriptions, useTemplates } from '../../api/queries';
import type { Exercise, Patient, StopDesign } from '../../api/types';
import { DateField, isDateOrEmpty } from '../../components/forms/DateField';
import { Notice, Problem } from '../../components/Feedback';
import { t } from '../../i18n';
import { DAYS, dayName } from '../../lib/assessment/practice';
import { isWalk, exerciseOf, primaryAngles } from '../../lib/exercises';
import { LimitRows } from '../template/editor/StopRules';

const NO_TEMPLATE = 'none';
const MOST_TIMES = 4;
const FIRST_TIME = '09:00';
/** Limits of the factor on the band, in percent. */
const NARROWEST = 50;
const WIDEST = 300;

export function PrescribeForm({ patient, onDone }: { patient: Patient; onDone: () => void }) {
  const exercises = useExercises();
  const present = usePrescriptions(patient.id);
  const [exerciseId, setExerciseId] = useState<string | null>(null);
  const [templateId, setTemplateId] = useState<string | null>(null);
  const [repetitions, setRepetitions] = useState(10);
  const [sets, setSets] = useState(1);
  const [perWeek, setPerWeek] = useState(5);
  const [days, setDays] = useState<string[]>([]);
  const [times, setTimes] = useState<string[]>([]);
  const [percent, setPercent] = useState<number | string>(100);
  const [stops, setStops] = useState<StopDesign[]>([]);
  const [question, setQuestion] = useState('');
  const [endsAt, setEndsAt] = useState('');
  const templates = useTemplates(exerciseId, patient.id, exerciseId !== null);
  const prescribe = usePrescribe(patient.id);
  const choices = templates.data ?? [];
  const exercise = exercises.data?.find((one) => one.id === exerciseId);
  const isWalked = isWalk(exerciseOf(exercises.data, exerciseId)?.movement);
  const chosen = templateId ?? choices[0]?.id ?? NO_TEMPLATE;
  const hasTemplate = chosen !== NO_TEMPLATE;
  const submit = (event: FormEvent) => {
    event.preventDefault();
    if (!exerciseId || !isDateOrEmpty(endsAt)) return;
    prescribe.mutate(
      {
        exercise_id: exerciseId,
        template_id: chosen === NO_TEMPLATE ? null : chosen,
        repetitions: isWalked ? 1 : repetitions,
        sets: isWalked ? 1 : sets,
        times_per_week: perWeek,
        days: days.map(Number),
        times: days.length ? times.filter(Boolean) : [],
        tolerance_scale: hasTemplate ? Math.min(WIDEST, Math.max(NARROWEST, Number(percent) || 100)) / 100 : 1,
        stops: hasTemplate && !isWalked ? stops : [],
        question,
        ends_at: endsAt ? new Date(`${endsAt}T23:59:59`).toISOString() : null,
      },
      { onSuccess: onDone },
    );
  };
  return (
    <form className="stack" onSubmit={submit}>
      {prescribe.error && <Problem error={prescribe.error} />}
      {exercises.error && <Problem error={exercises.error} />}
      <Select
        label={t('prescription.exercise')}
        placeholder={t('prescription.chooseExercise')}
        required
        withAsterisk={false}
        searchable
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
      {present.data?.some((one) => one.exercise_id === exerciseId) && <Notice>{t('prescription.twice')}</Notice>}
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
          {!isWalked && <Limits exercise={exercise} stops={stops} onChange={setStops} />}
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
        <Button type="submit" disabled={!exerciseId} loading={prescribe.isPending}>
          {t('prescription.prescribe')}
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

function Limits({
  exercise,
  stops,
  onChange,
}: {
  exercise: Exercise;
  stops: StopDesign[];
  onChange: (stops: StopDesign[]) => void;
}) {
  const angles = primaryAngles(exercise.side ?? 'right');
  return (
    <fieldset className="fieldset">
      <legend>{t('prescription.stops')}</legend>
      <p className="muted small">{t('prescription.stopsHelp')}</p>
      <LimitRows
        stops={stops}
        channels={angles}
        primary={exercise.primary_angle || (angles[0] ?? '')}
        onChange={onChange}
      />
    </fieldset>
  );
}
