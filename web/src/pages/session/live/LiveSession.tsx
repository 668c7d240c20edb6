// A session while it happens: the body and its curves side by side, sensors below; count and delay always in view.
import { useQueryClient } from '@tanstack/react-query';
import { useEffect, useMemo, useRef, useState } from 'react';
import { useParams } from 'react-router';
import { key } from '../../../api/address';
import { useExercises, usePatient, useSession } from '../../../api/queries';
import type { CalibrationMessage, SessionDetail, SessionEvent, SessionState } from '../../../api/types';
import { QueryBoundary, Problem } from '../../../components/Feedback';
import { Page } from '../../../components/Page';
import { Viewer3D } from '../../../components/Viewer3D';
import { useSignedIn } from '../../../components/account/useSignedIn';
import { Traces } from '../../../charts/Traces';
import { t } from '../../../i18n';
import { kindOf, nearOf } from '../../../kinds';
import { panelsOf } from '../../../kinds/panels';
import type { LiveProps } from '../../../kinds/kind';
import { fullName, patientCrumbs } from '../../../lib/people';
import { wornPlacements } from '../../../lib/placements';
import { isUnchecked } from '../../../lib/calibration';
import { eventText } from '../../../lib/events';
import { number, position } from '../../../lib/format';
import { massChannels } from '../../../lib/assessment/massCentre';
import { sessionTitle } from '../../../lib/sessions';
import { useLivePlayer, useSnapshot } from '../../../player/hooks';
import type { LivePlayer, LiveSnapshot } from '../../../player/live';
import { CalibrationPanel, panelOf } from '../../calibration/CalibrationPanel';
import { InForce } from '../../calibration/InForce';
import { AnalysisWait } from '../AnalysisWait';
import { ConnectHelp } from './ConnectHelp';
import { HealthPanel, SensorLine } from './HealthPanel';
import { LiveBanners } from './LiveBanners';
import { LiveButtons } from './LiveButtons';
import { NotStored } from './NotStored';
import { Repetitions } from './Repetitions';
import { StateSteps, stepOf } from './StateSteps';
import './LiveSession.css';

const LIVE = { mode: 'live' } as const;
/** How often HTTP is asked where no socket gets through. */
const ASK_MS = 3000;

function Delay({ snapshot }: { snapshot: LiveSnapshot }) {
  const service = snapshot.health?.latency_ms_median ?? null;
  const network = snapshot.networkMs;
  const isKnown =
    service !== null && network !== null && snapshot.silentSinceS === null && snapshot.connection === 'open';
  return (
    <span
      className="delay"
      title={isKnown ? t('live.delayParts', { service: number(service), network: number(network) }) : undefined}
    >
      <span className="muted">{t('live.delay')}</span>{' '}
      <span className="number strong" data-testid="delay">
        {isKnown ? `${number(service + network)} ms` : '–'}
      </span>
    </span>
  );
}

function Happened({ events }: { events: readonly SessionEvent[] }) {
  // How the calibration came out is said in its own card.
  const newest = events
    .filter((one) => !isUnchecked(one))
    .reverse()
    .slice(0, 8);
  return (
    <section className="card" aria-labelledby="happened">
      <div className="card-head">
        <h2 id="happened">{t('live.events')}</h2>
      </div>
      {newest.length === 0 ? (
        <p className="muted">{t('live.noEvents')}</p>
      ) : (
        <ul className="plain-list lines small">
          {newest.map((event, index) => (
            <li key={`${event.time_s}${event.kind}${index}`}>
              <span className="muted number">{position(event.time_s, 0)}</span> {eventText(event)}
            </li>
          ))}
        </ul>
      )}
    </section>
  );
}

function Room({ session, player }: { session: SessionDetail; player: LivePlayer }) {
  const client = useQueryClient();
  const me = useSignedIn();
  const mayRecord = session.may_treat || me.role === 'patient';
  const snapshot = useSnapshot(player);
  const { isBlocked } = snapshot;
  // Where no socket gets through, HTTP tells the state.
  useSession(session.id, isBlocked ? ASK_MS : undefined);
  const exercises = useExercises();
  const exercise = exercises.data?.find((one) => one.id === session.exercise_id);
  const message = isBlocked ? null : snapshot.state;
  const state: SessionState = message?.state ?? session.state;
  const step = useRef(0);
  // The socket's word counts once there is one: its start is null again when the recording was stopped.
  const isRecording =
    state === 'recording' ||
    (state === 'link_lost' &&
      (message
        ? message.recording_start_s !== null
        : session.recording_start_s !== null && session.recording_end_s === null));
  const inForce = message?.calibration ?? session.calibration;
  step.current = stepOf(state, step.current, {
    isCalibrated: inForce !== null && !inForce.needs_headings,
    isRecording,
  });
  useEffect(() => {
    if (state === 'closing' || state === 'analysed')
      void client.invalidateQueries({ queryKey: key('sessions', session.id) });
  }, [state, client, session.id]);

  // After a loss what was read before may be of before.
  const isOpen = snapshot.connection === 'open';
  useEffect(() => {
    if (isOpen) void client.invalidateQueries({ queryKey: key('sessions', session.id) });
  }, [isOpen, client, session.id]);

  const isOver = state === 'closing' || state === 'analysed' || state === 'failed';
  // Without a calibration the way to one is the first thing; later it comes when asked for, or when one runs.
  const [isAsked, setAsked] = useState(false);
  // A result that was read is put away; the next message of a running calibration brings the guide back.
  const [read, setRead] = useState<CalibrationMessage | null>(null);
  const calibration = message ? message.calibration : session.calibration;
  const kind = kindOf(session);
  const { First, Guide, Start, Curves, Side } = panelsOf(session).live;
  const mass = useMemo(() => massChannels(session.layout.scalars), [session.layout.scalars]);
  const isUnset = state === 'calibrating' && kind.needsPose;
  const mayCalibrate = kind.needsPose && (state === 'calibrating' || state === 'ready');
  const panel = mayCalibrate ? panelOf(snapshot.calibration, read, isAsked || state === 'calibrating') : null;
  const shown: LiveProps = {
    session,
    player,
    message,
    state,
    columns: snapshot.columns,
    exercise: session.exercise_id && exercises.isPending ? null : exercise,
    isRecording,
    mayRecord,
  };
  const isStarted = state !== 'created';
  return (
    <>
      <div className="live-head">
        <StateSteps step={step.current} />
        {!isOver && (
          <div className="live-now">
            <Repetitions guidance={snapshot.guidance} isKnown={isOpen} />
            <SensorLine health={isOpen ? snapshot.health : null} isUncalibrated={isUnset} />
            <Delay snapshot={snapshot} />
          </div>
        )}
      </div>
      {!isOver && <LiveBanners snapshot={snapshot} isLinkLost={state === 'link_lost'} known={session} />}
      {snapshot.connection === 'open' && !isOver && <NotStored health={snapshot.health} />}
      {state === 'created' && message?.reason && (
        <div className="banner banner-note" role="status">
          <p>{message.reason}</p>
        </div>
      )}
      {state === 'failed' && (
        <Problem error={new Error(message?.reason || session.state_reason)} title={t('live.failed')} />
      )}
      {snapshot.error && !snapshot.error.closing && <Problem error={new Error(snapshot.error.message)} />}
      {isOver && state !== 'failed' && (
        <div className="spaced">
          <AnalysisWait session={session} state={state} />
        </div>
      )}
      {isOver ? (
        <Happened events={snapshot.events.length ? snapshot.events : session.events} />
      ) : (
        <div className="stack">
          {First && <First {...shown} />}
          {state === 'created' && <ConnectHelp session={session} />}
          {panel && (
            <CalibrationPanel
              sessionId={session.id}
              placements={wornPlacements(session)}
              guide={snapshot.calibration}
              shows={panel}
              hint={message?.calibration_hint ?? ''}
              mayAct={mayRecord}
              isNeeded={state === 'calibrating'}
              isRemembered={calibration?.needs_headings ?? false}
              onRead={setRead}
              onClose={() => setAsked(false)}
            />
          )}
          {Guide && isStarted && <Guide {...shown} />}
          {isStarted && mayRecord && (
            <LiveButtons sessionId={session.id} state={state} isRecording={isRecording} isGuided={kind.isGuided} />
          )}
          {Start && isStarted && <Start {...shown} />}
          {isStarted && (
            <div className="live-grid">
              <Viewer3D
                sessionId={session.id}
                request={LIVE}
                title={t('viewer.liveTitle')}
                near={nearOf(session)}
                player={player}
              />
              <div className="stack">
                {Curves && !isUnset && <Curves {...shown} />}
                {isUnset && (
                  <section className="card">
                    <p className="muted">{t(inForce?.needs_headings ? 'live.noCurvesYet' : 'live.noCurvesBefore')}</p>
                  </section>
                )}
                {mass.length > 0 && !isUnset && snapshot.columns && (
                  <section className="card" aria-labelledby="mass">
                    <h2 id="mass">{t('mass.title')}</h2>
                    <Traces player={player} channels={mass} />
                  </section>
                )}
                {Side && <Side {...shown} />}
              </div>
            </div>
          )}
          <div className="live-below">
            <HealthPanel
              health={snapshot.health}
              placements={wornPlacements(session)}
              isOutOfReach={snapshot.connection === 'lost'}
              isUncalibrated={isUnset}
            />
            {state === 'ready' && kind.needsPose && calibration && mayRecord && !panel && (
              <InForce
                sessionId={session.id}
                calibration={calibration}
                placements={wornPlacements(session)}
                onAgain={() => setAsked(true)}
              />
            )}
            <Happened events={snapshot.events.length ? snapshot.events : session.events} />
          </div>
        </div>
      )}
    </>
  );
}

function Loaded({ session }: { session: SessionDetail }) {
  const player = useLivePlayer(session.id);
  return player ? <Room session={session} player={player} /> : null;
}

export function LiveSessionPage() {
  const { sessionId = '' } = useParams();
  const session = useSession(sessionId);
  const patient = usePatient(session.data?.patient_id ?? '');
  const name = patient.data ? fullName(patient.data) : '';
  return (
    <Page
      compact
      title={name || t('live.title')}
      lead={session.data ? sessionTitle(session.data) : undefined}
      crumbs={patientCrumbs(session.data?.patient_id, name)}
    >
      <QueryBoundary of={session} lines={8} height={50}>
        {(data) => <Loaded key={data.id} session={data} />}
      </QueryBoundary>
    </Page>
  );
}
