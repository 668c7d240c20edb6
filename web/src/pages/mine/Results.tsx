import { Link } from 'react-router';
import { usePatientSessions, usePrescriptions, useProgress } from '../../api/queries';
import { ProgressChart } from '../../charts/ProgressChart';
import { Answer } from '../../components/Feedback';
import { Page } from '../../components/Page';
import { useSignedIn } from '../../components/useSignedIn';
import { t } from '../../i18n';
import { day, duration } from '../../lib/format';
import { mainMeasure, plainProgress } from '../../lib/plain';
import { NoRecord } from './Today';

function Exercise({ patientId, exerciseId, name }: { patientId: string; exerciseId: string; name: string }) {
  const progress = useProgress(patientId, exerciseId);
  return (
    <section className="card">
      <h2>{name}</h2>
      <Answer of={progress} lines={3}>
        {(data) => {
          const measure = mainMeasure(data.measures);
          return (
            <>
              <p className="mine-say">{plainProgress(measure)}</p>
              {measure && measure.points.length > 1 && (
                <details className="as-table">
                  <summary>{t('mine.showCurve')}</summary>
                  <ProgressChart measure={measure} events={[]} height={220} />
                </details>
              )}
            </>
          );
        }}
      </Answer>
    </section>
  );
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
              const done = list.filter((one) => one.state === 'analysed');
              return done.length === 0 ? (
                <p className="muted">{t('mine.noSessions')}</p>
              ) : (
                <ul className="plain-list lines">
                  {done.slice(0, 20).map((one) => (
                    <li key={one.id}>
                      <Link to={`/sessions/${one.id}`} className="mine-link">
                        {one.exercise_name ?? t('session.free')}
                      </Link>
                      <div className="muted">
                        {day(one.started_at ?? one.created_at)} · {duration(one.duration_s)}
                      </div>
                    </li>
                  ))}
                </ul>
              );
            }}
          </Answer>
        </section>
      </div>
    </Page>
  );
}

export function ResultsPage() {
  const me = useSignedIn();
  return me.patient_id ? <Results patientId={me.patient_id} /> : <NoRecord />;
}
