import { IconCheck, IconChevronRight } from '@tabler/icons-react';
import { Link } from 'react-router';
import { usePatientSessions, usePrescriptions, useProgress } from '../../api/queries';
import type { ProgressMeasure, Session } from '../../api/types';
import { QueryBoundary, ShowMore } from '../../components/Feedback';
import { Page } from '../../components/Page';
import { useSignedIn } from '../../components/account/useSignedIn';
import { t } from '../../i18n';
import { Sparkline } from '../../charts/Sparkline';
import { dayName, DAYS } from '../../lib/assessment/practice';
import { clockTime, quantity, weekday } from '../../lib/format';
import { valuesByDay, practisedWeeks } from '../../lib/assessment/ownDays';
import { mainMeasure, plainValue, repetitionsOf, shortName } from '../../lib/plain';
import { HowItGoes } from './HowItGoes';
import { NoRecord } from './Today';
import { sessionTitle } from '../../lib/sessions';
import './Results.css';

/** How her own value went, a point a day; one day is no curve. */
function Curve({ main }: { main: ProgressMeasure }) {
  const days = valuesByDay(main);
  const last = days.at(-1);
  if (!last || days.length < 2) return null;
  return (
    <div className="trend">
      <Sparkline
        values={days.map((one) => one.value)}
        days={days.map((one) => one.day)}
        low={[]}
        high={[]}
        unit={main.unit}
        label={shortName(main)}
        width={210}
        height={60}
      />
      <span className="strong">{quantity(last.value, main.unit)}</span>
    </div>
  );
}

/** On which days of the last weeks she practised: a row a week. */
function Calendar({ at, isWhole }: { at: readonly string[]; isWhole: boolean }) {
  const weeks = practisedWeeks(at, isWhole);
  if (weeks.length === 0) return null;
  return (
    <section className="card">
      <h2>{t('mine.days')}</h2>
      <table className="mine-days">
        <thead>
          <tr>
            {DAYS.map((one) => (
              <th key={one} scope="col">
                <abbr title={dayName(one, 'long')}>{dayName(one, 'short')}</abbr>
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {weeks.map((week) => (
            <tr key={week[0]?.at.toISOString()}>
              {week.map(({ at: day, state }) => (
                <td key={day.toISOString()} className={`mine-day mine-day-${state}`}>
                  {day.getDate()}
                  {state === 'practised' && (
                    <>
                      <IconCheck size={16} aria-hidden />
                      <span className="visually-hidden">{t('mine.dayPractised')}</span>
                    </>
                  )}
                </td>
              ))}
            </tr>
          ))}
        </tbody>
      </table>
    </section>
  );
}

function Exercise({ patientId, exerciseId, name }: { patientId: string; exerciseId: string; name: string }) {
  const progress = useProgress(patientId, exerciseId);
  return (
    <section className="card">
      <h2>{name}</h2>
      <QueryBoundary of={progress} lines={3}>
        {(data) => {
          const main = mainMeasure(data.measures);
          return (
            <>
              <HowItGoes measures={data.measures} />
              {main && <Curve main={main} />}
            </>
          );
        }}
      </QueryBoundary>
    </section>
  );
}

const begun = (one: Session) => one.started_at ?? one.created_at;

/** One session: when, what it was, how often, how long, and the way to look at it. */
function Done({ session, repetitions, value = '' }: { session: Session; repetitions: number | null; value?: string }) {
  const name = sessionTitle(session);
  const minutes = Math.round(session.duration_s / 60);
  const said = [
    clockTime(begun(session)),
    ...(repetitions ? [t('home.times', { count: repetitions })] : []),
    minutes > 0 ? t('home.minutes', { count: minutes }) : t('home.underMinute'),
  ].join(', ');
  const words = (
    <span>
      <span className="strong">{name}</span>
      <span className="muted">{said}</span>
      {value && <span>{value}</span>}
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
  const measures = progress.data?.measures ?? [];
  return (
    <Done
      session={session}
      repetitions={repetitionsOf(measures, session.id)}
      value={session.purpose === 'template' ? t('mine.forTemplate') : plainValue(mainMeasure(measures), session.id)}
    />
  );
}

/** Sessions by the day on which they began, newest first. */
export function byDay(sessions: readonly Session[]): [day: string, sessions: Session[]][] {
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
        <QueryBoundary of={prescriptions} lines={3}>
          {(list) => (
            <>
              {[...new Map(list.map((one) => [one.exercise_id, one.exercise_name])).entries()].map(([id, name]) => (
                <Exercise key={id} patientId={patientId} exerciseId={id} name={name} />
              ))}
            </>
          )}
        </QueryBoundary>
        <Calendar
          at={(sessions.data ?? []).filter((one) => one.state === 'analysed' && one.purpose !== 'template').map(begun)}
          isWhole={!sessions.hasNextPage}
        />
        <section className="card">
          <h2>{t('mine.sessions')}</h2>
          <QueryBoundary of={sessions} lines={4}>
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
          </QueryBoundary>
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
