import { IconChevronRight } from '@tabler/icons-react';
import { Link } from 'react-router';
import { usePatientSessions, usePrescriptions, useProgress } from '../../api/queries';
import type { Session } from '../../api/types';
import { Answer, ShowMore } from '../../components/Feedback';
import { Page } from '../../components/Page';
import { useSignedIn } from '../../components/account/useSignedIn';
import { t } from '../../i18n';
import { weekday } from '../../lib/format';
import { mainMeasure, plainProgress, repetitionsOf } from '../../lib/plain';
import { NoRecord } from './Today';

function Exercise({ patientId, exerciseId, name }: { patientId: string; exerciseId: string; name: string }) {
  const progress = useProgress(patientId, exerciseId);
  return (
    <section className="card">
      <h2>{name}</h2>
      <Answer of={progress} lines={3}>
        {(data) => <p className="mine-say">{plainProgress(mainMeasure(data.measures))}</p>}
      </Answer>
    </section>
  );
}

/** One session: what it was, how often, how long, and the way to look at it. */
function Done({ session, repetitions }: { session: Session; repetitions: number | null }) {
  const name = session.exercise_name ?? t('session.free');
  const minutes = Math.round(session.duration_s / 60);
  const said = [
    ...(repetitions ? [t('home.times', { count: repetitions })] : []),
    minutes > 0 ? t('home.minutes', { count: minutes }) : t('home.underMinute'),
  ].join(', ');
  const words = (
    <span>
      <span className="strong">{name}</span>
      <span className="muted">{said.charAt(0).toUpperCase() + said.slice(1)}</span>
      {session.state === 'closing' && <span className="muted">{t('home.beingPrepared')}</span>}
    </span>
  );
  return (
    <li>
      {session.state === 'analysed' ? (
        <Link to={`/my/sessions/${session.id}`} className="home-done">
          {words}
          <IconChevronRight size={26} aria-hidden />
        </Link>
      ) : (
        <div className="home-done">{words}</div>
      )}
    </li>
  );
}

/** The same with the repetitions that its exercise's progress counts; asked once for all sessions of an exercise. */
function DoneExercise({ session, exerciseId }: { session: Session; exerciseId: string }) {
  const progress = useProgress(session.patient_id, exerciseId);
  return <Done session={session} repetitions={repetitionsOf(progress.data?.measures ?? [], session.id)} />;
}

/** Sessions by the day on which they began, newest first. */
export function byDay(sessions: readonly Session[]): [day: string, sessions: Session[]][] {
  const begun = (one: Session) => one.started_at ?? one.created_at;
  const days = new Map<string, Session[]>();
  for (const one of [...sessions].sort((a, b) => Date.parse(begun(b)) - Date.parse(begun(a)))) {
    const day = weekday(begun(one));
    days.set(day, [...(days.get(day) ?? []), one]);
  }
  return [...days.entries()];
}

function Results({ patientId }: { patientId: string }) {
  const prescriptions = usePrescriptions(patientId);
  const sessions = usePatientSessions(patientId);
  return (
    <Page narrow title={t('nav.myResults')} lead={t('mine.resultsLead')}>
      <div className="stack">
        <Answer of={prescriptions} lines={3}>
          {(list) => (
            <>
              {[...new Map(list.map((one) => [one.exercise_id, one.exercise_name])).entries()].map(([id, name]) => (
                <Exercise key={id} patientId={patientId} exerciseId={id} name={name} />
              ))}
            </>
          )}
        </Answer>
        <section className="card">
          <h2>{t('mine.sessions')}</h2>
          <Answer of={sessions} lines={4}>
            {(list) => {
              const done = list.filter((one) => one.state === 'analysed' || one.state === 'closing');
              if (done.length === 0) return <p className="muted">{t('mine.noSessions')}</p>;
              return byDay(done).map(([day, ofDay]) => (
                <section key={day} className="home-day">
                  <h3>{day}</h3>
                  <ul className="plain-list lines">
                    {ofDay.map((one) =>
                      one.exercise_id ? (
                        <DoneExercise key={one.id} session={one} exerciseId={one.exercise_id} />
                      ) : (
                        <Done key={one.id} session={one} repetitions={null} />
                      ),
                    )}
                  </ul>
                </section>
              ));
            }}
          </Answer>
          <ShowMore of={sessions} />
        </section>
      </div>
    </Page>
  );
}

export function ResultsPage() {
  const me = useSignedIn();
  return me.patient_id ? <Results patientId={me.patient_id} /> : <NoRecord />;
}
