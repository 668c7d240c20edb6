// The patient's first page: what to do today, one large button each, plain words.
import { Button } from '@mantine/core';
import { IconCircleCheckFilled, IconMoodHappy, IconPlayerPlayFilled } from '@tabler/icons-react';
import { lazy, Suspense } from 'react';
import { Link, useNavigate } from 'react-router';
import { useNewSession } from '../../api/changes';
import { useExercises, usePatient, usePatientSessions, usePrescriptions, useProgress } from '../../api/queries';
import type { Me, Prescription, Session, SessionIn } from '../../api/types';
import { QueryBoundary, Empty } from '../../components/Feedback';
import { Page } from '../../components/Page';
import { useSignedIn } from '../../components/account/useSignedIn';
import { t } from '../../i18n';
import { isWalk } from '../../lib/exercises';
import { kindFor } from '../../kinds';
import { HowItGoes } from './HowItGoes';
import {
  isBegun,
  isDoneForWeek,
  isOpenToday,
  scheduleText,
  todayText,
  painText,
  sessionsText,
} from '../../lib/assessment/practice';
import { isLive, sessionTitle } from '../../lib/sessions';
import { PlainProblem } from './PlainProblem';
import './Today.css';

const Unsent = lazy(() => import('../../sensors/Unsent'));

/** To put sensors on, and for a repetition with its rest. */
const SENSORS_S = 120;
const REPETITION_S = 7;

function doseWords({ sets, repetitions }: Prescription, isWalked: boolean): string {
  if (isWalked) return t('mine.walk');
  return sets > 1 ? t('mine.setsOf', { sets, repetitions }) : t('mine.times', { count: repetitions });
}

/** How long it takes: as it took this patient before, sensors included; else as it usually does. */
export function minutesOf(prescription: Prescription, sessions: readonly Session[]): number {
  const before = sessions.filter(
    (one) => one.exercise_id === prescription.exercise_id && one.purpose === 'exercise' && one.duration_s > 30,
  );
  const usual = SENSORS_S + REPETITION_S * prescription.sets * prescription.repetitions;
  const took = before.length ? before.reduce((sum, one) => sum + one.duration_s, 0) / before.length + SENSORS_S : usual;
  return Math.max(1, Math.round(took / 60));
}

function minutesText(minutes: readonly number[]): string {
  return t('mine.about', { count: minutes.reduce((sum, one) => sum + one, 0) });
}

function ExerciseCard({ prescription, patientId }: { prescription: Prescription; patientId: string }) {
  const navigate = useNavigate();
  const patient = usePatient(patientId);
  const exercises = useExercises();
  const sessions = usePatientSessions(patientId);
  const create = useNewSession();
  const exercise = exercises.data?.find((one) => one.id === prescription.exercise_id);
  const isWalked = isWalk(exercise?.movement);
  const kind = kindFor(exercise?.movement);
  const isDone = !isOpenToday(prescription);
  const today = isDone ? '' : todayText(prescription);
  const begin = t(isDone ? 'mine.again' : isBegun(prescription) ? 'mine.goOn' : 'mine.start');
  const start = () =>
    create.mutate(
      {
        patient_id: patientId,
        exercise_id: prescription.exercise_id,
        prescription_id: prescription.id,
        pipeline: kind.pipeline as NonNullable<SessionIn['pipeline']>,
        placements: kind.begin?.usual?.(patient.data?.affected_side, exercise?.primary_angle) ?? [],
      },
      { onSuccess: (session) => void navigate(`/my/sessions/${session.id}/live`) },
    );
  return (
    <li className="card mine-card">
      <div>
        <h2>{prescription.exercise_name}</h2>
        {exercise?.description && <p>{exercise.description}</p>}
        {exercises.data && (
          <p className="strong">
            {doseWords(prescription, isWalked)}, {minutesText([minutesOf(prescription, sessions.data ?? [])])}
          </p>
        )}
        {today && <p className="strong">{today}</p>}
        <p className="muted">
          {isDone
            ? isDoneForWeek(prescription)
              ? [t('mine.doneForWeek'), painText(prescription)].filter(Boolean).join(', ')
              : t('mine.onDays', { days: scheduleText(prescription) })
            : sessionsText(prescription)}
        </p>
      </div>
      <Button
        size="xl"
        variant={isDone ? 'default' : 'filled'}
        leftSection={
          isDone ? <IconCircleCheckFilled size={26} aria-hidden /> : <IconPlayerPlayFilled size={26} aria-hidden />
        }
        loading={create.isPending}
        disabled={!patient.data || !exercises.data}
        onClick={start}
        aria-label={`${begin}: ${prescription.exercise_name}`}
      >
        {begin}
      </Button>
      {create.error && <PlainProblem error={create.error} />}
    </li>
  );
}

function Today({ me, patientId }: { me: Me; patientId: string }) {
  const prescriptions = usePrescriptions(patientId);
  const sessions = usePatientSessions(patientId);
  const progress = useProgress(patientId, null);
  // Asked for with the list, not only by its cards.
  usePatient(patientId);
  useExercises();
  const running = sessions.data?.find((one) => isLive(one.state));
  const due = (prescriptions.data ?? []).filter(isOpenToday);
  const done = (prescriptions.data ?? []).filter((one) => !isOpenToday(one));
  return (
    <Page
      narrow
      title={t('mine.hello', { name: me.display_name.split(' ')[0] ?? me.display_name })}
      lead={
        prescriptions.data && prescriptions.data.length > 0
          ? due.length > 0
            ? t('mine.today', {
                count: due.length,
                time: minutesText(due.map((one) => minutesOf(one, sessions.data ?? []))),
              })
            : t(done.every(isDoneForWeek) ? 'mine.allDone' : 'mine.doneToday')
          : undefined
      }
    >
      <div className="stack">
        <Suspense fallback={null}>
          <Unsent />
        </Suspense>
        {running && (
          <section className="card mine-card">
            <div>
              <h2>{t('mine.running')}</h2>
              <p>{sessionTitle(running)}</p>
            </div>
            <Button size="xl" component={Link} to={`/my/sessions/${running.id}/live`}>
              {t('mine.goOn')}
            </Button>
          </section>
        )}
        <QueryBoundary of={prescriptions} lines={4} height={60}>
          {(list) =>
            list.length === 0 ? (
              <div className="card">
                <Empty icon={<IconMoodHappy size={52} aria-hidden />} title={t('mine.nothingTitle')}>
                  {t('mine.nothingText')}
                </Empty>
              </div>
            ) : (
              <ul className="plain-list stack">
                {[...due, ...done].map((one) => (
                  <ExerciseCard key={one.id} prescription={one} patientId={patientId} />
                ))}
              </ul>
            )
          }
        </QueryBoundary>
        <section className="card">
          <h2>{t('mine.how')}</h2>
          <QueryBoundary of={progress} lines={2}>
            {(data) => <HowItGoes measures={data.measures} />}
          </QueryBoundary>
          <Link to="/my/results" className="mine-link">
            {t('mine.seeResults')}
          </Link>
        </section>
      </div>
    </Page>
  );
}

export function TodayPage() {
  const me = useSignedIn();
  return me.patient_id ? <Today me={me} patientId={me.patient_id} /> : <NoRecord />;
}

/** An account with the role patient that no record belongs to yet. */
export function NoRecord() {
  return (
    <Page narrow title={t('nav.today')}>
      <div className="card">
        <Empty title={t('mine.noRecord')}>{t('mine.noRecordText')}</Empty>
      </div>
    </Page>
  );
}
