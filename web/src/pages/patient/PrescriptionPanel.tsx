import { Button, Modal } from '@mantine/core';
import { useDisclosure } from '@mantine/hooks';
import { IconPlus, IconRouteOff } from '@tabler/icons-react';
import { Link } from 'react-router';
import { useEndPrescription } from '../../api/changes';
import { useExercises, usePrescriptions } from '../../api/queries';
import type { Patient, Prescription } from '../../api/types';
import { Confirm } from '../../components/forms/Confirm';
import { QueryBoundary, Notice, Problem } from '../../components/Feedback';
import { t } from '../../i18n';
import { isWalk, exerciseOf } from '../../lib/exercises';
import { date, number } from '../../lib/format';
import { scheduleText, weekText } from '../../lib/assessment/practice';
import { PrescribeForm } from './prescribe/PrescribeForm';
import './PrescriptionPanel.css';

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

function Line({ prescription, patient }: { prescription: Prescription; patient: Patient }) {
  const end = useEndPrescription(patient.id);
  const [isOpen, dialog] = useDisclosure(false);
  const exercises = useExercises();
  const isTest = isWalk(exerciseOf(exercises.data, prescription.exercise_id)?.movement);
  const done = Math.min(prescription.done_this_week, prescription.times_per_week);
  return (
    <li>
      <div className="line-head">
        <span className="strong">{prescription.exercise_name}</span>
        {patient.may_treat && (
          <span className="line-buttons">
            <Button
              size="sm"
              variant="default"
              aria-label={t('prescription.changeOf', { name: prescription.exercise_name })}
              onClick={dialog.open}
            >
              {t('prescription.change')}
            </Button>
            <Confirm
              label={t('prescription.end')}
              title={t('prescription.endTitle', { name: prescription.exercise_name })}
              text={t('prescription.endText')}
              confirm={t('prescription.end')}
              onConfirm={() => end.mutate(prescription.id)}
            />
          </span>
        )}
      </div>
      {exercises.data && <div>{doseText(prescription, isTest)}</div>}
      {prescription.days.length > 0 && <div>{scheduleText(prescription)}</div>}
      {(prescription.tolerance_scale !== 1 || prescription.stops.length > 0) && (
        <div className="small">
          {[
            prescription.tolerance_scale !== 1 &&
              t('prescription.band', { percent: number(100 * prescription.tolerance_scale) }),
            prescription.stops.length > 0 && t('prescription.limits', { count: prescription.stops.length }),
          ]
            .filter(Boolean)
            .join(' · ')}
        </div>
      )}
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
      {(prescription.troubles ?? []).map((one) => (
        <Notice key={one}>{one}</Notice>
      ))}
      <History prescription={prescription} isWalked={isTest} />
      {end.error && <Problem error={end.error} />}
      <Modal
        opened={isOpen}
        onClose={dialog.close}
        size="lg"
        title={t('prescription.changeTitle', { name: prescription.exercise_name })}
        closeButtonProps={{ 'aria-label': t('action.close') }}
      >
        <PrescribeForm patient={patient} prescription={prescription} onDone={dialog.close} />
      </Modal>
    </li>
  );
}

/** What it was before each change, and who changed it when. */
function History({ prescription, isWalked }: { prescription: Prescription; isWalked: boolean }) {
  const changes = prescription.changes ?? [];
  if (!changes.length) return null;
  // Each state is what came after it with the fields that were changed as they were.
  let state: Prescription = prescription;
  return (
    <details className="small">
      <summary>{t('prescription.history', { count: changes.length })}</summary>
      <ul className="plain-list">
        {changes.map((one) => {
          state = { ...state, ...(one.before as Partial<Prescription>) };
          return (
            <li key={one.changed_at}>
              {t('prescription.changed', {
                date: date(one.changed_at),
                name: one.changed_by,
                before: [
                  doseText(state, isWalked),
                  'tolerance_scale' in one.before &&
                    t('prescription.band', { percent: number(100 * state.tolerance_scale) }),
                  'template_id' in one.before && t('prescription.otherTemplate'),
                  'stops' in one.before && t('prescription.limits', { count: state.stops.length }),
                ]
                  .filter(Boolean)
                  .join(' · '),
              })}
            </li>
          );
        })}
      </ul>
    </details>
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
      <QueryBoundary of={prescriptions} lines={3}>
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
      </QueryBoundary>
      <Modal
        opened={isOpen}
        onClose={dialog.close}
        size="lg"
        title={t('prescription.dialogTitle')}
        closeButtonProps={{ 'aria-label': t('action.close') }}
      >
        <PrescribeForm patient={patient} onDone={dialog.close} />
      </Modal>
    </section>
  );
}
