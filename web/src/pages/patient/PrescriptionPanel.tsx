import { Button, Group, Modal, NumberInput, Select, SimpleGrid } from '@mantine/core';
import { useDisclosure } from '@mantine/hooks';
import { IconPlus, IconRouteOff } from '@tabler/icons-react';
import { useState, type FormEvent } from 'react';
import { Link } from 'react-router';
import { useEndPrescription, useExercises, usePrescribe, usePrescriptions, useTemplates } from '../../api/queries';
import type { Patient, Prescription } from '../../api/types';
import { Confirm } from '../../components/forms/Confirm';
import { DateField, isDateOrEmpty } from '../../components/forms/DateField';
import { Answer, Notice, Problem } from '../../components/Feedback';
import { t } from '../../i18n';
import { isWalk, movementOf } from '../../lib/exercises';
import { date } from '../../lib/format';
import { weekText } from '../../lib/assessment/practice';

/** The dose in words: sets, repetitions, times a week. A walk is walked once in a session. */
export function doseText(
  prescription: Pick<Prescription, 'sets' | 'repetitions' | 'times_per_week'>,
  isWalked: boolean,
): string {
  const { sets, repetitions, times_per_week: perWeek } = prescription;
  const dose = isWalked
    ? t('prescription.walk')
    : sets > 1
      ? t('prescription.setsOf', { sets, repetitions })
      : t('prescription.repetitions', { count: repetitions });
  return t('prescription.dose', { dose, perWeek });
}

const NO_TEMPLATE = 'none';

function PrescribeForm({ patient, onDone }: { patient: Patient; onDone: () => void }) {
  const exercises = useExercises();
  const present = usePrescriptions(patient.id);
  const [exerciseId, setExerciseId] = useState<string | null>(null);
  const [templateId, setTemplateId] = useState<string | null>(null);
  const [repetitions, setRepetitions] = useState(10);
  const [sets, setSets] = useState(1);
  const [perWeek, setPerWeek] = useState(5);
  const [endsAt, setEndsAt] = useState('');
  const templates = useTemplates(exerciseId, patient.id, exerciseId !== null);
  const prescribe = usePrescribe(patient.id);
  const choices = templates.data ?? [];
  const isWalked = isWalk(movementOf(exercises.data, exerciseId));
  const chosen = templateId ?? choices[0]?.id ?? NO_TEMPLATE;
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
        data={(exercises.data ?? []).map((one) => ({ value: one.id, label: one.name }))}
        value={exerciseId}
        onChange={(value) => {
          setExerciseId(value);
          setTemplateId(null);
        }}
        data-autofocus
      />
      {present.data?.some((one) => one.exercise_id === exerciseId) && <Notice>{t('prescription.twice')}</Notice>}
      {exerciseId && templates.data && !isWalked && (
        <Select
          label={t('prescription.template')}
          description={choices.length ? t('prescription.templateHelp') : t('prescription.noTemplateHelp')}
          data={[
            ...choices.map((one) => ({ value: one.id, label: one.name })),
            { value: NO_TEMPLATE, label: t('prescription.without') },
          ]}
          value={chosen}
          onChange={setTemplateId}
        />
      )}
      <SimpleGrid cols={isWalked ? 1 : 3}>
        {!isWalked && (
          <>
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
          </>
        )}
        <NumberInput
          maw={200}
          label={t('prescription.perWeekLabel')}
          min={1}
          max={28}
          value={perWeek}
          onChange={(value) => setPerWeek(Number(value) || 1)}
        />
      </SimpleGrid>
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

function Line({ prescription, patient }: { prescription: Prescription; patient: Patient }) {
  const end = useEndPrescription(patient.id);
  const exercises = useExercises();
  const isTest = isWalk(movementOf(exercises.data, prescription.exercise_id));
  const done = Math.min(prescription.done_this_week, prescription.times_per_week);
  return (
    <li>
      <div className="line-head">
        <span className="strong">{prescription.exercise_name}</span>
        {patient.may_treat && (
          <Confirm
            label={t('prescription.end')}
            title={t('prescription.endTitle', { name: prescription.exercise_name })}
            text={t('prescription.endText')}
            confirm={t('prescription.end')}
            onConfirm={() => end.mutate(prescription.id)}
          />
        )}
      </div>
      {exercises.data && <div>{doseText(prescription, isTest)}</div>}
      <div className="small week">
        <span className="dots" aria-hidden>
          {Array.from({ length: Math.min(14, prescription.times_per_week) }, (_, index) => (
            <span key={index} className={index < done ? 'dot dot-full' : 'dot'} />
          ))}
        </span>
        {weekText(prescription)}
      </div>
      {prescription.is_twice && <div className="small missing">{t('prescription.isTwice')}</div>}
      {prescription.template_name ? (
        <div className="small">
          <Link to={`/exercises/${prescription.exercise_id}?patient=${patient.id}`}>
            {t('prescription.withTemplate', { name: prescription.template_name })}
          </Link>
        </div>
      ) : isTest ? null : (
        <div className="small missing">
          <IconRouteOff size={16} aria-hidden /> {t('prescription.noTemplate')}{' '}
          {patient.may_treat && (
            <Link to={`/templates/record?patient=${patient.id}&exercise=${prescription.exercise_id}`}>
              {t('template.record')}
            </Link>
          )}
        </div>
      )}
      {prescription.ends_at && (
        <div className="muted small">{t('prescription.endsOn', { date: date(prescription.ends_at) })}</div>
      )}
      {end.error && <Problem error={end.error} />}
    </li>
  );
}

export function PrescriptionPanel({ patient }: { patient: Patient }) {
  const prescriptions = usePrescriptions(patient.id);
  const [isOpen, dialog] = useDisclosure(false);
  return (
    <section className="card" aria-labelledby="prescriptions">
      <div className="card-head">
        <h2 id="prescriptions">{t('prescription.title')}</h2>
        {patient.may_treat && (
          <Button
            className="end"
            size="sm"
            variant="default"
            leftSection={<IconPlus size={17} aria-hidden />}
            onClick={dialog.open}
          >
            {t('prescription.prescribe')}
          </Button>
        )}
      </div>
      <Answer of={prescriptions} lines={3}>
        {(list) =>
          list.length === 0 ? (
            <p className="muted">{t('prescription.none')}</p>
          ) : (
            <ul className="plain-list lines">
              {list.map((one) => (
                <Line key={one.id} prescription={one} patient={patient} />
              ))}
            </ul>
          )
        }
      </Answer>
      <Modal
        opened={isOpen}
        onClose={dialog.close}
        title={t('prescription.dialogTitle')}
        closeButtonProps={{ 'aria-label': t('action.close') }}
      >
        <PrescribeForm patient={patient} onDone={dialog.close} />
      </Modal>
    </section>
  );
}
