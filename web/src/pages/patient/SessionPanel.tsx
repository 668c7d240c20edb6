import { Button } from '@mantine/core';
import { useState } from 'react';
import { Link } from 'react-router';
import { usePatientSessions, usePatientWorries, useWalks } from '../../api/queries';
import type { Patient, Session, Worry } from '../../api/types';
import { QueryBoundary, ShowMore } from '../../components/Feedback';
import { ReasonMark, StateMark } from '../../components/Marks';
import { t } from '../../i18n';
import { day, duration } from '../../lib/format';
import { isLive, lossText, sessionPath, sessionTitle } from '../../lib/sessions';
import './SessionPanel.css';

const SHOWN_FIRST = 8;

function Line({ session, worries }: { session: Session; worries: readonly Worry[] }) {
  const loss = lossText(session);
  return (
    <li className="session-line">
      <Link to={sessionPath(session)} className="session-link">
        <span className="strong">{sessionTitle(session)}</span>
        <span className="muted small">
          {day(session.started_at ?? session.created_at)}
          {session.duration_s > 0 && ` · ${duration(session.duration_s)}`}
          {session.purpose === 'template' && ` · ${t('session.forTemplate')}`}
          {session.source === 'upload' && ` · ${t('session.uploaded')}`}
        </span>
        {loss && <span className="small">{loss}</span>}
        {worries.length > 0 && (
          <span className="session-worries">
            {worries.map((one) => (
              <ReasonMark key={one.kind} reason={one.kind} />
            ))}
          </span>
        )}
      </Link>
      {(session.state !== 'analysed' || isLive(session.state)) && <StateMark state={session.state} />}
    </li>
  );
}

export function SessionPanel({ patient }: { patient: Patient }) {
  const sessions = usePatientSessions(patient.id);
  const walks = useWalks(patient.id);
  const worries = usePatientWorries(patient.id).data ?? [];
  const [showsAll, setShowsAll] = useState(false);
  return (
    <section className="card" aria-labelledby="sessions">
      <div className="card-head">
        <h2 id="sessions">{t('session.list')}</h2>
        {(walks.data?.length ?? 0) > 1 && (
          <Link className="end" to={`/patients/${patient.id}/walks`}>
            {t('before.link')}
          </Link>
        )}
      </div>
      <QueryBoundary of={sessions} lines={5}>
        {(list) =>
          list.length === 0 ? (
            <p className="muted">{t('session.none')}</p>
          ) : (
            <>
              <ul className="plain-list lines">
                {(showsAll ? list : list.slice(0, SHOWN_FIRST)).map((one) => (
                  <Line key={one.id} session={one} worries={worries.filter((of) => of.session_id === one.id)} />
                ))}
              </ul>
              {showsAll && <ShowMore of={sessions} />}
              {list.length > SHOWN_FIRST && (
                <Button
                  mt={14}
                  variant="default"
                  size="sm"
                  aria-expanded={showsAll}
                  onClick={() => setShowsAll(!showsAll)}
                >
                  {showsAll
                    ? t('session.fewer')
                    : sessions.hasNextPage
                      ? t('action.showMore')
                      : t('session.all', { count: list.length })}
                </Button>
              )}
            </>
          )
        }
      </QueryBoundary>
    </section>
  );
}
