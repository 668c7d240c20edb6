// What the patient has to know of a live session at this moment: one thing, and only what is known here.
import { kindOf } from '../../kinds';
import type { SessionDetail, SessionState } from '../../api/types';
import { isRunning } from '../../lib/calibration';
import type { LiveSnapshot } from '../../player/live';

export type Moment =
  | 'refused'
  | 'lost'
  | 'blocked'
  | 'silent'
  | 'putOn'
  | 'wait'
  | 'still'
  | 'holding'
  | 'again'
  | 'ready'
  | 'going'
  | 'preparing'
  | 'done'
  | 'failed';

type Stored = Pick<SessionDetail, 'state' | 'pipeline' | 'recording_start_s' | 'recording_end_s'>;

/** The state as the socket says it; as it was read where the socket has said nothing yet. */
export function stateOf(snapshot: Pick<LiveSnapshot, 'state'>, session: Pick<Stored, 'state'>): SessionState {
  // An analysis ends after the socket has said its last word; its result can be shown once it has been read.
  if (session.state === 'analysed') return 'analysed';
  const said = snapshot.state?.state ?? session.state;
  return said === 'analysed' ? 'closing' : said;
}

/** Whether a recording runs, with or without a signal at this moment. */
export function isRecording(snapshot: Pick<LiveSnapshot, 'state'>, session: Stored): boolean {
  const state = stateOf(snapshot, session);
  const begun = snapshot.state
    ? snapshot.state.recording_start_s !== null
    : session.recording_start_s !== null && session.recording_end_s === null;
  return state === 'recording' || (state === 'link_lost' && begun);
}

/** The one thing to say. */
export function momentOf(
  snapshot: Pick<LiveSnapshot, 'state' | 'connection' | 'silentSinceS' | 'calibration'> & { isBlocked?: boolean },
  session: Stored,
): Moment {
  const state = stateOf(snapshot, session);
  if (state === 'analysed') return 'done';
  if (state === 'closing') return 'preparing';
  if (state === 'failed') return 'failed';
  if (snapshot.connection === 'refused') return 'refused';
  if (snapshot.connection === 'lost') return snapshot.isBlocked ? 'blocked' : 'lost';
  if (state === 'created') return 'putOn';
  if (state === 'link_lost' || (snapshot.silentSinceS !== null && state !== 'calibrating')) return 'silent';
  if (state === 'recording') return 'going';
  const guide = snapshot.calibration;
  if (guide && isRunning(guide)) return 'holding';
  if (state === 'ready') return 'ready';
  // A walk finds out by itself how its sensors sit.
  if (!kindOf(session).needsPose) return 'wait';
  return guide?.phase === 'redo' ? 'again' : 'still';
}
