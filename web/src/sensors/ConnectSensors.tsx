// A patient measures without a gateway: with this phone in a strap, or with Bluetooth sensors. One choice, then one tap.
import { Button, UnstyledButton } from '@mantine/core';
import { IconBluetooth, IconDeviceMobile, IconRouter } from '@tabler/icons-react';
import { useMutation } from '@tanstack/react-query';
import { lazy, Suspense, useState, type ReactNode } from 'react';
import { useNavigate } from 'react-router';
import { ofSession } from '../api/address';
import { byHand } from '../api/client';
import type { Placement, SessionDetail, SessionIn } from '../api/types';
import { useSignedIn } from '../components/account/useSignedIn';
import { t, withinSentence } from '../i18n';
import { useExercises } from '../api/queries';
import { placementLabel } from '../lib/channels';
import { exerciseOf } from '../lib/exercises';
import { forPosture } from '../lib/posture';
import { PlainProblem } from '../pages/mine/PlainProblem';
import { Phone } from './phone';
import { isMeasuring } from './registry';
import { type Owner, SensorRun } from './run';
import { SensorFault } from './source';
import { SensorStatus } from './SensorStatus';
import './sensors.css';
import { giveUpTurn, takeTurn } from './turn';
import { useRun } from './useRun';

type Way = 'phone' | 'bluetooth' | 'box';

const NewBox = lazy(() => import('./NewBox'));

/** Where a phone can be worn in this session: one upper arm is all that a single sensor tells of. */
function phonePlace(session: SessionDetail): Placement | null {
  const places = session.placements as Placement[];
  return places.find((place) => place.startsWith('upper_arm')) ?? null;
}

function Fault({ error }: { error: unknown }) {
  if (!error) return null;
  if (!(error instanceof SensorFault)) return <PlainProblem error={error} />;
  return (
    <p className="problem" role="alert">
      {t(`sensors.fault.${error.code}`)}
    </p>
  );
}

const WAYS = [
  { way: 'phone', Icon: IconDeviceMobile, IconRouter },
  { way: 'bluetooth', Icon: IconBluetooth },
  { way: 'box', Icon: IconRouter },
] as const;

/** In mid-exercise only what goes on with this session here: a phone that is its one sensor, or its Bluetooth sensors. */
function waysFor(session: SessionDetail, isMidway: boolean): Way[] {
  const hasPlace = phonePlace(session) !== null;
  if (!isMidway) return hasPlace ? ['phone', 'bluetooth', 'box'] : ['bluetooth', 'box'];
  const isPhone = navigator.maxTouchPoints > 0;
  return hasPlace && isPhone && session.placements.length === 1 ? ['phone', 'bluetooth'] : ['bluetooth'];
}

function Choice({ ways, title, onChoose }: { ways: readonly Way[]; title: string; onChoose: (way: Way) => void }) {
  return (
    <section className="card" aria-labelledby="sensor-ways">
      <h2 id="sensor-ways">{title}</h2>
      <div className="sensor-ways">
        {WAYS.filter(({ way }) => ways.includes(way)).map(({ way, Icon }) => (
          <UnstyledButton key={way} className="sensor-way" onClick={() => onChoose(way)}>
            <Icon size={32} aria-hidden />
            <span>
              <span className="strong">{t(`sensors.${way}`)}</span>
              <span className="sensor-way-text">{t(`sensors.${way}Text`)}</span>
            </span>
          </UnstyledButton>
        ))}
      </div>
    </section>
  );
}

/** A phone is one sensor: a session that expects more is begun anew with one, and the empty one ended. */
async function sessionFor(session: SessionDetail, place: Placement): Promise<SessionDetail> {
  if (session.placements.length === 1) return session;
  const made = await byHand.post('/api/sessions', {
    body: {
      patient_id: session.patient_id,
      exercise_id: session.exercise_id,
      prescription_id: session.prescription_id,
      pipeline: session.pipeline as NonNullable<SessionIn['pipeline']>,
      placements: [place],
      // How a clinic's sensor sat says nothing about a phone.
      use_mounting: false,
    },
  });
  await byHand.post('/api/sessions/{session_id}/close', ofSession(session.id));
  return made;
}

function WithPhone({
  session,
  place,
  onRun,
}: {
  session: SessionDetail;
  place: Placement;
  onRun: (run: SensorRun) => void;
}) {
  const me = useSignedIn();
  const navigate = useNavigate();
  const exercise = exerciseOf(useExercises().data, session.exercise_id);
  const begin = useMutation({
    mutationFn: async () => {
      const phone = new Phone();
      await phone.start();
      try {
        await takeTurn();
        const joined = await sessionFor(session, place);
        return { joined, run: await SensorRun.withPhone(phone, ownerOf(joined, me.account_id), place) };
      } catch (error) {
        phone.stop();
        if (!isMeasuring()) giveUpTurn();
        throw error;
      }
    },
    onSuccess: ({ joined, run }) => {
      if (joined.id === session.id) onRun(run);
      else void navigate(`/my/sessions/${joined.id}/live`, { replace: true });
    },
  });
  return (
    <>
      <div className="home-steps">
        <ol>
          <li>{t('sensors.phoneStrap', { place: withinSentence(placementLabel(place)) })}</li>
          <li>{t('sensors.phoneTight')}</li>
          <li>{t('sensors.phoneStart')}</li>
        </ol>
      </div>
      <p>{t('sensors.phoneSees')}</p>
      <p className="muted">
        {t('sensors.phoneSeesNot')} {forPosture('upright', exercise?.posture)}
      </p>
      <Button size="xl" fullWidth loading={begin.isPending} onClick={() => begin.mutate()}>
        {t('sensors.phoneGo')}
      </Button>
      <Fault error={begin.error} />
    </>
  );
}

function ownerOf(session: SessionDetail, accountId: string): Owner {
  return { sessionId: session.id, accountId, next: session.packets_stored + session.packets_missing };
}

function WithBluetooth({ session, onRun }: { session: SessionDetail; onRun: (run: SensorRun) => void }) {
  const me = useSignedIn();
  const places = session.placements as Placement[];
  const [run, snapshot, show] = useRun(session.id);
  const choose = useMutation({
    mutationFn: async (place: Placement) => {
      const one = run ?? (await SensorRun.withBluetooth(ownerOf(session, me.account_id), places));
      show(one);
      await one.choose(place);
      if (one.getSnapshot().gateway) onRun(one);
    },
  });
  const missing = places.filter((place) => snapshot?.sensors[place]?.status !== 'measuring').length;
  return (
    <>
      <p>{t('sensors.dotSteps')}</p>
      <ul className="plain-list sensor-places">
        {places.map((place) => {
          const state = snapshot?.sensors[place];
          const isChosen = state !== undefined && state.status !== 'failed';
          return (
            <li key={place}>
              {isChosen && (
                <span>
                  <span className="strong">{placementLabel(place)}</span> {state.name}:{' '}
                  {t(`sensors.status.${state.status}`)}
                </span>
              )}
              <Button
                size={isChosen ? 'sm' : 'lg'}
                fullWidth={!isChosen}
                variant={isChosen ? 'default' : 'filled'}
                disabled={choose.isPending}
                aria-label={isChosen ? t('sensors.dotAgainFor', { place: placementLabel(place) }) : undefined}
                onClick={() => choose.mutate(place)}
              >
                {isChosen ? t('sensors.dotAgain') : t('sensors.dotChoose', { place: placementLabel(place) })}
              </Button>
            </li>
          );
        })}
      </ul>
      {missing > 0 && <p className="muted">{t('sensors.dotMissing', { count: missing })}</p>}
      <Fault error={choose.error} />
    </>
  );
}

/**
 * For the page of a live session. Until something measures here it shows how to begin with the clinic's box, and the
 * other ways; then what is stored and sent.
 */
export default function ConnectSensors({
  session,
  isWaiting,
  isMidway = false,
  box,
}: {
  session: SessionDetail;
  /** Nothing comes from anywhere yet. */
  isWaiting: boolean;
  /** The exercise is recorded already, and the signal was lost. */
  isMidway?: boolean;
  /** The steps with the box. */
  box?: ReactNode;
}) {
  const [run, snapshot, setRun] = useRun(session.id);
  const [way, setWay] = useState<Way | null>(null);
  const place = phonePlace(session);
  if (run && snapshot?.gateway) return <SensorStatus run={snapshot} />;
  if (!isWaiting) return null;
  if (way === null)
    return (
      <>
        {box}
        <Choice
          ways={waysFor(session, isMidway)}
          title={t(isMidway ? 'sensors.again' : 'sensors.title')}
          onChoose={setWay}
        />
      </>
    );
  return (
    <section className="card stack">
      <h2>{t(`sensors.${way}`)}</h2>
      {way === 'phone' && place && <WithPhone session={session} place={place} onRun={setRun} />}
      {way === 'box' && (
        <Suspense fallback={null}>
          <NewBox patientId={session.patient_id} onDone={() => setWay(null)} />
        </Suspense>
      )}
      {way === 'bluetooth' && <WithBluetooth session={session} onRun={setRun} />}
      <Button
        variant="subtle"
        onClick={() => {
          SensorRun.of(session.id)?.stop();
          setWay(null);
        }}
      >
        {t('sensors.back')}
      </Button>
    </section>
  );
}
