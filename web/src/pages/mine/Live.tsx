// The patient's own live page: one large sentence, one large button, and the picture.
import { Button, Progress } from '@mantine/core';
import {
  IconAntennaBarsOff,
  IconCheck,
  IconHandStop,
  IconPlayerPlayFilled,
  IconPlayerStopFilled,
  IconRun,
} from '@tabler/icons-react';
import { useMutation, useQueryClient } from '@tanstack/react-query';
import { lazy, Suspense, useEffect, useState } from 'react';
import { Link, useParams } from 'react-router';
import { byHand } from '../../api/client';
import { key, ofSession } from '../../api/address';
import { useExercises, useGrants, useSession } from '../../api/queries';
import type { CalibrationMessage, HealthMessage, Placement, PlayerState, SessionDetail } from '../../api/types';
import { Confirm } from '../../components/forms/Confirm';
import { Waiting } from '../../components/Feedback';
import { Page } from '../../components/Page';
import { Viewer3D } from '../../components/Viewer3D';
import { nearOf } from '../../kinds';
import { t } from '../../i18n';
import { placementLabel, placementList } from '../../lib/channels';
import { exerciseOf } from '../../lib/exercises';
import { wornLimbs } from '../../lib/placements';
import { forPosture } from '../../lib/posture';
import { useLivePlayer, useSnapshot } from '../../player/hooks';
import type { LivePlayer } from '../../player/live';
import { StepPicture } from '../../pictures/StepPicture';
import { WearPicture } from '../../pictures/WearPicture';
import { useCalibrating } from '../calibration/useCalibrating';
import { Elsewhere, useElsewhere } from '../../sensors/Elsewhere';
import { measuringFor, sendRest } from '../../sensors/registry';
import { Controls, Count, isGuided, NowLine } from './exercise/Doing';
import { hasHurt } from './exercise/hurt';
import { useHold } from './exercise/useHold';
import { isRecording, momentOf, type Moment } from './moment';
import { PlainProblem } from './PlainProblem';
import './Live.css';

const ConnectSensors = lazy(() => import('../../sensors/ConnectSensors'));
/** Loaded while she moves, so that it is there when the link has ended. */
const loadAfter = () => import('./exercise/After');
const After = lazy(loadAfter);

const LIVE = { mode: 'live' } as const;
const EMPTY_PERCENT = 15;
/** How often to ask whether the result is ready. */
const ASK_MS = 2000;
/** So long somebody tries to hold still before another way is offered. */
const ANOTHER_WAY_MS = 20_000;
const READ_MS = 4_000;
/** What keeps the pose from being held, of all that a calibration says. */
const TROUBLES: readonly string[] = ['live.moved', 'live.sends_nothing', 'live.gap_hold'];

const ICONS: Partial<Record<Moment, typeof IconRun>> = {
  lost: IconAntennaBarsOff,
  blocked: IconAntennaBarsOff,
  silent: IconAntennaBarsOff,
  holding: IconHandStop,
  still: IconHandStop,
  again: IconHandStop,
  going: IconRun,
  ready: IconCheck,
  preparing: IconCheck,
  done: IconCheck,
};
const BAD: readonly Moment[] = ['lost', 'blocked', 'silent', 'refused', 'failed'];
const MOVING: readonly Moment[] = ['still', 'holding', 'again', 'wait', 'ready', 'going', 'silent', 'lost'];
/** The pose was held: the picture says so by colour, word and tick. */
const GREEN: readonly Moment[] = ['ready'];
const DOING: readonly Moment[] = ['going', 'silent', 'lost'];
const OPEN: readonly Moment[] = ['putOn', 'still', 'again', 'wait', 'ready', 'silent'];

/** How to begin, in the order in which it is done. */
function PutOn({ session }: { session: SessionDetail }) {
  return (
    <section className="card home-steps">
      <ol>
        <li>
          {t('home.wear')}
          <div className="wear">
            <WearPicture
              placements={session.placements as Placement[]}
              label={t('doing.wearPicture', { places: placementList(session.placements) })}
            />
            <ol>
              {session.placements.map((place) => (
                <li key={place}>{placementLabel(place)}</li>
              ))}
            </ol>
          </div>
          {session.placements.some((place) => /_(left|right)$/.test(place)) && (
            <p className="muted small">{t('doing.facesYou')}</p>
          )}
        </li>
        <li>{t('home.switchOn')}</li>
        <li>{t('home.deviceOn')}</li>
      </ol>
      <details className="as-table">
        <summary>{t('home.helpTitle')}</summary>
        <ul>
          <li>{t('home.helpCharged')}</li>
          <li>{t('home.helpNear')}</li>
          <li>{t('home.helpAsk')}</li>
        </ul>
      </details>
    </section>
  );
}

/** Sensors that need a hand; nothing while all is well. */
function Sensors({ health, isResting }: { health: HealthMessage | null; isResting: boolean }) {
  const places = (wanted: (one: HealthMessage['sensors'][number]) => boolean) =>
    placementList((health?.sensors ?? []).filter(wanted).map((one) => one.placement));
  const lost = places((one) => one.status === 'lost');
  const empty = places(
    (one) => one.status !== 'lost' && typeof one.battery_percent === 'number' && one.battery_percent <= EMPTY_PERCENT,
  );
  if (!lost && !empty) return null;
  return (
    <div className={`banner ${isResting ? 'banner-note' : 'banner-alert'}`} role={isResting ? undefined : 'alert'}>
      <div>
        {lost && <p>{t('home.sensorLost', { places: lost })}</p>}
        {empty && <p>{t('home.sensorEmpty', { places: empty })}</p>}
      </div>
    </div>
  );
}

/** What was measured here is not with the service yet: ending now would leave it behind. */
class StillSending extends Error {}

function Trouble({ error }: { error: unknown }) {
  if (!(error instanceof StillSending)) return <PlainProblem error={error} />;
  return (
    <p className="problem" role="alert">
      {t('home.stillSending')}
    </p>
  );
}

/** What keeps the pose from being still, by its part; after a while another way to hold it. */
export function Unsteady({ guide }: { guide: CalibrationMessage | null }) {
  const [isLong, setLong] = useState(false);
  useEffect(() => {
    const timer = setTimeout(() => setLong(true), ANOTHER_WAY_MS);
    return () => clearTimeout(timer);
  }, []);
  const [trouble, setTrouble] = useState('');
  const hint = guide?.sentences?.hint;
  const now = hint && !Array.isArray(hint) && TROUBLES.includes(hint.code) ? (guide?.hint ?? '') : '';
  useEffect(() => {
    if (now) setTrouble(now);
    // A tremor comes and goes: its words stay long enough to be read.
    const timer = now ? undefined : setTimeout(() => setTrouble(''), READ_MS);
    return () => clearTimeout(timer);
  }, [now]);
  return (
    <div role="status">
      {trouble && <p className="strong">{trouble}</p>}
      {isLong && <p>{t('home.stillOther')}</p>}
    </div>
  );
}

function Room({ session, player }: { session: SessionDetail; player: LivePlayer }) {
  const client = useQueryClient();
  const heard = useSnapshot(player);
  // Where no socket gets through, HTTP tells the state.
  const snapshot = heard.isBlocked ? { ...heard, state: null } : heard;
  const [shown, setShown] = useState<PlayerState | null>(null);
  const moment = momentOf(snapshot, session);
  useSession(session.id, moment === 'preparing' || moment === 'blocked' ? ASK_MS : undefined);
  const isOpen = snapshot.connection === 'open';
  useEffect(() => {
    if (isOpen) void client.invalidateQueries({ queryKey: key('sessions', session.id) });
  }, [isOpen, client, session.id]);
  const { start, cancel, error } = useCalibrating(session.id);
  const records = isRecording(snapshot, session);
  useEffect(() => {
    if (records) loadAfter().catch(() => undefined);
  }, [records]);
  const deed = useMutation({
    mutationFn: async (what: 'record' | 'end') => {
      if (what === 'record') return byHand.post('/api/sessions/{session_id}/record', ofSession(session.id));
      if (records) await byHand.post('/api/sessions/{session_id}/stop', ofSession(session.id));
      if (!(await sendRest(session.id))) throw new StillSending();
      return byHand.post('/api/sessions/{session_id}/close', ofSession(session.id));
    },
    onSettled: () => client.invalidateQueries({ queryKey: key('sessions', session.id) }),
  });
  // How the sensors sit may be known from last time: then holding still sets the directions only.
  const known = (snapshot.state ? snapshot.state.calibration : session.calibration)?.needs_headings ?? false;
  const guide = snapshot.calibration;
  const Icon = ICONS[moment];
  const problem = deed.error ?? error;
  const isStill = moment === 'still' || moment === 'again';
  const { guidance } = snapshot;
  const hold = useHold(session.id, guidance);
  const exercise = exerciseOf(useExercises().data, session.exercise_id);
  // A service that says nothing of guidance takes no buttons either.
  const isDoing = guidance !== null && records && DOING.includes(moment);
  const isBad = BAD.includes(moment);
  // What measures here says itself that nothing is lost; this page alone would not know.
  const isStoredHere = moment === 'lost' && measuringFor(session.id) !== null;
  // Who rests needs no signal: that it is missing stands large as soon as she goes on.
  const isResting = isDoing && hold.held !== null && hold.held !== 'lost';
  const isWaiting = moment === 'putOn' || (moment === 'silent' && !isResting);
  const isElsewhere = useElsewhere(isWaiting);
  const isHurt = (moment === 'preparing' || moment === 'done') && hasHurt(session, guidance);
  const therapists = (useGrants(session.patient_id, isHurt).data ?? []).filter((one) => one.level === 'treat');
  const therapist = therapists.length === 1 ? therapists[0]?.display_name : undefined;
  return (
    <div className={isDoing ? 'stack doing' : 'stack'}>
      {(moment === 'going' || moment === 'ready') && snapshot.health?.is_being_stored === false && (
        <div className="banner banner-alert" role="alert">
          <div>
            <p className="strong">{t('home.notStored')}</p>
            <p>{t('home.notStoredText')}</p>
          </div>
        </div>
      )}
      {isDoing && (!isBad || isResting) && (
        <NowLine
          guidance={guidance}
          hold={hold}
          posture={exercise?.posture}
          missing={moment === 'silent' || (moment === 'lost' && !isStoredHere) ? moment : null}
          onFinish={() => deed.mutate('end')}
          isEnding={deed.isPending}
        />
      )}
      {isElsewhere && <Elsewhere />}
      {(!isDoing || isBad) && !isResting && !isStoredHere && !isElsewhere && (
        <section
          className={`card home-moment ${isBad ? 'home-moment-bad' : ''} ${GREEN.includes(moment) ? 'home-moment-green' : ''} ${moment === 'going' ? 'home-moment-go' : ''}`}
        >
          <div role="status">
            <h2>
              {Icon && !isHurt && <Icon size={38} aria-hidden />}
              {isHurt ? t('home.moment.hurt') : t(`home.moment.${moment}`)}
            </h2>
            {isHurt && <p>{t('home.moment.hurt.text', { name: therapist ?? t('home.moment.hurt.someone') })}</p>}
            <p>{moment === 'ready' ? forPosture('ready', exercise?.posture) : t(`home.moment.${moment}.text`)}</p>
          </div>
          {moment === 'holding' && <Unsteady guide={guide} />}
          {moment === 'holding' && guide && (
            <Progress
              value={100 * (guide.phase === 'evaluating' ? 1 : guide.step_progress)}
              size="xl"
              transitionDuration={0}
              aria-label={t('home.holdingProgress')}
            />
          )}
          {isStill && (
            <>
              <div className="home-figure">
                <StepPicture picture="n_pose" worn={wornLimbs(session.placements)} />
              </div>
              <Button
                size="xl"
                fullWidth
                loading={start.isPending}
                onClick={() => start.mutate({ kind: known ? 'heading_reset' : 'n_pose' })}
              >
                {t('home.standing')}
              </Button>
              <p className="muted">{t('home.cannotStand')}</p>
            </>
          )}
          {moment === 'holding' && (
            <Button size="lg" fullWidth variant="default" loading={cancel.isPending} onClick={() => cancel.mutate()}>
              {t('home.cancelStill')}
            </Button>
          )}
          {moment === 'ready' && (
            <Button
              size="xl"
              fullWidth
              loading={deed.isPending}
              leftSection={<IconPlayerPlayFilled size={30} aria-hidden />}
              onClick={() => deed.mutate('record')}
            >
              {t('home.go')}
            </Button>
          )}
          {moment === 'blocked' && (
            <p>{t('home.moment.blocked.state', { state: t(`sessionState.${session.state}`) })}</p>
          )}
          {records && !isDoing && (moment === 'going' || moment === 'silent' || moment === 'blocked') && (
            <Button
              size="xl"
              fullWidth
              className="stop-button"
              loading={deed.isPending}
              leftSection={<IconPlayerStopFilled size={30} aria-hidden />}
              onClick={() => deed.mutate('end')}
            >
              {t('home.finished')}
            </Button>
          )}
          {moment === 'going' && snapshot.health?.is_being_stored && <p className="muted">{t('home.stored')}</p>}
          {moment === 'done' && (
            <Button size="xl" fullWidth component={Link} to={`/my/sessions/${session.id}`}>
              {t('home.look')}
            </Button>
          )}
          {(moment === 'preparing' || moment === 'done' || moment === 'failed' || moment === 'refused') && (
            <Button size="lg" fullWidth variant="default" component={Link} to="/">
              {t('home.back')}
            </Button>
          )}
          {problem && !isDoing && <Trouble error={problem} />}
        </section>
      )}
      {isDoing && problem && <Trouble error={problem} />}
      {(moment === 'preparing' || moment === 'done') && session.exercise_id && (
        <Suspense fallback={<Waiting />}>
          <After session={session} guidance={guidance} />
        </Suspense>
      )}
      <Suspense fallback={null}>
        <ConnectSensors
          session={session}
          isWaiting={isWaiting && !isElsewhere}
          isMidway={records}
          box={moment === 'putOn' && <PutOn session={session} />}
        />
      </Suspense>
      {moment !== 'putOn' && MOVING.includes(moment) && (
        <>
          {moment !== 'lost' && moment !== 'silent' && <Sensors health={snapshot.health} isResting={isResting} />}
          {isDoing && isGuided(guidance) && <Count guidance={guidance} />}
          <Viewer3D
            sessionId={session.id}
            request={LIVE}
            title={t('home.picture')}
            near={nearOf(session)}
            player={player}
            onShown={setShown}
            from={records ? 'movement' : 'start'}
            isPlain
          />
          {shown?.has_ghost && <p className="muted doing-example">{t('home.example')}</p>}
          {isDoing && <Controls guidance={guidance} hold={hold} />}
        </>
      )}
      {!records && OPEN.includes(moment) && (
        <div>
          <Confirm
            label={t('home.end')}
            title={t('home.endTitle')}
            text={t('home.endText')}
            confirm={t('home.end')}
            onConfirm={() => deed.mutate('end')}
          />
        </div>
      )}
    </div>
  );
}

function Loaded({ session }: { session: SessionDetail }) {
  const player = useLivePlayer(session.id);
  return player ? <Room session={session} player={player} /> : null;
}

export function MyLivePage() {
  const { sessionId = '' } = useParams();
  const session = useSession(sessionId);
  return (
    <Page narrow compact title={session.data?.exercise_name ?? t('home.title')}>
      {session.data ? (
        <Loaded key={session.data.id} session={session.data} />
      ) : session.error ? (
        <PlainProblem error={session.error} onRetry={() => void session.refetch()} />
      ) : (
        <Waiting lines={6} height={50} />
      )}
    </Page>
  );
}
