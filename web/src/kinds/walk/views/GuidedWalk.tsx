// A walking test guided while it is recorded: what to do, a clock that all can read, and what the feet have done so far.
import { Button } from '@mantine/core';
import { IconPlayerRecordFilled, IconPlayerStopFilled } from '@tabler/icons-react';
import { useMutation, useQueryClient } from '@tanstack/react-query';
import { useEffect, useState } from 'react';
import { byHand } from '../../../api/client';
import { key, ofSession } from '../../../api/address';
import type { SessionDetail, SessionState, StateMessage } from '../../../api/types';
import { Problem } from '../../../components/Feedback';
import { t } from '../../../i18n';
import { number, position } from '../../../lib/format';
import {
  countdown,
  minutePrompt,
  SessionClock,
  SIX_MINUTES_S,
  WalkTally,
  type WalkKind,
  type WalkSoFar,
} from '../guidedWalk';
import type { Player } from '../../../player/types';
import './views.css';
import './GuidedWalk.css';

const REFRESH_MS = 100;

export interface GuidedWalkProps {
  session: Pick<SessionDetail, 'id' | 'recording_start_s' | 'recording_end_s'>;
  player: Player;
  /** The newest word of the service on the state, null before the first. */
  message: Pick<StateMessage, 'session_time_s' | 'recording_start_s'> | null;
  /** Null while it is not known yet. */
  kind: WalkKind | null;
  state: SessionState;
  isRecording: boolean;
  mayRecord: boolean;
  /** By so much the frames show what was. */
  delayS: number;
}

interface Now {
  elapsedS: number;
  walked: WalkSoFar | null;
  /** Where counting began when the page was opened late. */
  lateS: number | null;
}

/** Follow the recording that runs; what was shown last stays when it is stopped. */
function useNow({ session, player, message, isRecording, delayS }: GuidedWalkProps): Now | null {
  const startS = isRecording ? (message ? message.recording_start_s : session.recording_start_s) : null;
  const [clock] = useState(() => new SessionClock());
  const [now, setNow] = useState<Now | null>(null);
  useEffect(() => {
    if (message) clock.set(message.session_time_s);
  }, [clock, message]);
  useEffect(() => {
    if (startS === null) return;
    const tally = new WalkTally(startS + delayS);
    const look = () => {
      const { endS } = player.clock();
      if (endS > 0) clock.set(endS);
      tally.take(player);
      const sessionS = clock.read();
      if (sessionS === null) return;
      setNow({
        elapsedS: Math.max(0, sessionS - startS),
        walked: tally.countedFromS === null ? null : tally.read(),
        lateS: tally.isWhole ? null : (tally.countedFromS ?? 0) - delayS - startS,
      });
    };
    look();
    const timer = setInterval(look, REFRESH_MS);
    return () => clearInterval(timer);
  }, [clock, player, startS, delayS]);
  return now;
}

function Walked({ kind, walked, lateS }: { kind: WalkKind | null; walked: WalkSoFar; lateS: number | null }) {
  return (
    <>
      <dl className="figures-large">
        <div className="figure-large">
          <dt>{t('guided.distance')}</dt>
          <dd className="number" data-testid="guided-distance">
            {walked.distanceM === null ? '–' : `${number(walked.distanceM, walked.distanceM < 100 ? 1 : 0)} m`}
          </dd>
        </div>
        <div className="figure-large">
          <dt>{t('walk.steps')}</dt>
          <dd className="number" data-testid="guided-steps">
            {number(walked.steps)}
          </dd>
        </div>
        {kind === 'timed_up_and_go' && (
          <div className="figure-large">
            <dt>{t('guided.away')}</dt>
            <dd className="number">{walked.awayM === null ? '–' : `${number(walked.awayM, 1)} m`}</dd>
          </div>
        )}
      </dl>
      {lateS !== null && <p className="muted small">{t('guided.late', { time: position(lateS, 0) })}</p>}
    </>
  );
}

export function GuidedWalk(props: GuidedWalkProps) {
  const { session, kind, state, isRecording, mayRecord } = props;
  const client = useQueryClient();
  const now = useNow(props);
  const deed = useMutation({
    mutationFn: (what: 'record' | 'stop') => byHand.post(`/api/sessions/{session_id}/${what}`, ofSession(session.id)),
    onSuccess: () => client.invalidateQueries({ queryKey: key('sessions', session.id) }),
  });
  const stored =
    session.recording_start_s !== null && session.recording_end_s !== null
      ? session.recording_end_s - session.recording_start_s
      : null;
  const elapsedS = isRecording ? (now?.elapsedS ?? null) : (stored ?? now?.elapsedS ?? null);
  const isTest = kind !== null && kind !== 'walk';
  const isSix = kind === 'six_minute_walk';
  const isOver = isSix && isRecording && elapsedS !== null && elapsedS >= SIX_MINUTES_S;
  // A countdown stands at six minutes before; what was recorded counts up.
  const face =
    isSix && (isRecording || elapsedS === null) ? countdown(elapsedS ?? 0) : position(elapsedS ?? 0, isSix ? 0 : 1);
  const label = isRecording
    ? t(isSix ? 'guided.left' : 'guided.time')
    : elapsedS === null
      ? t('guided.before')
      : t('guided.recorded');
  const prompt =
    !isRecording || elapsedS === null
      ? ''
      : isSix
        ? minutePrompt(elapsedS)
        : kind === 'timed_up_and_go' && now?.walked
          ? t(`guided.leg.${now.walked.leg}`)
          : '';
  return (
    <section className="card guided-walk" aria-labelledby="guided-walk" data-over={isOver || undefined}>
      <div>
        <h2 id="guided-walk">{t(`walk.kind.${kind ?? 'walk'}`)}</h2>
        {kind && (
          <ol className="guided-steps">
            {(['first', 'then', 'last'] as const).map((step) => (
              <li key={step}>{t(`guided.${kind}.${step}`)}</li>
            ))}
          </ol>
        )}
      </div>
      <div className="guided-now">
        <p className="muted">{label}</p>
        <p className="guided-clock number" role="timer" aria-label={label} data-testid="guided-clock">
          {face}
        </p>
        <p className="guided-prompt strong" role="status" aria-live="polite">
          {prompt}
        </p>
        {now?.walked && <Walked kind={kind} walked={now.walked} lateS={now.lateS} />}
        {mayRecord &&
          (isRecording ? (
            <Button
              size="lg"
              className={isOver ? undefined : 'stop-button'}
              leftSection={<IconPlayerStopFilled size={20} aria-hidden />}
              loading={deed.isPending}
              onClick={() => deed.mutate('stop')}
            >
              {t(isTest ? 'guided.finish' : 'live.stop')}
            </Button>
          ) : (
            <Button
              size="lg"
              leftSection={<IconPlayerRecordFilled size={20} aria-hidden />}
              disabled={state !== 'ready'}
              loading={deed.isPending}
              onClick={() => deed.mutate('record')}
            >
              {t(!isTest ? 'live.record' : elapsedS === null ? 'guided.begin' : 'guided.again')}
            </Button>
          ))}
        {deed.error && <Problem error={deed.error} />}
      </div>
    </section>
  );
}
