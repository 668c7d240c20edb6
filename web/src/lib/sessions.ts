import type { Estimator, Result, Session, SessionDetail, SessionState } from '../api/types';
import { kindOf } from '../kinds';
import { t, tOr } from '../i18n';
import { number } from './format';

const LIVE: readonly SessionState[] = ['created', 'calibrating', 'ready', 'recording', 'link_lost'];

/** Whether packets may still come. */
export function isLive(state: SessionState): boolean {
  return LIVE.includes(state);
}

/** What was done: the exercise, or what is measured when there is none. */
export function sessionTitle(session: Pick<SessionDetail, 'exercise_name' | 'pipeline'>): string {
  return session.exercise_name ?? kindOf(session).free();
}

/** What made a result, as people read it: a filter that can be chosen, or the only one of its kind of session. */
export function estimatorTitle(result: Pick<Result, 'orientation'>, estimators: readonly Estimator[]): string {
  const found = estimators.find((one) => one.name === result.orientation);
  return found?.title ?? tOr(`estimator.${result.orientation}`, result.orientation);
}

/** The page that fits the state of a session. */
export function sessionPath(session: Pick<Session, 'id' | 'state'>): string {
  return session.state === 'analysed' ? `/sessions/${session.id}` : `/sessions/${session.id}/live`;
}

/** A word on lost packets, only where it matters (more than one in a hundred). */
export function lossText(session: Pick<Session, 'packets_stored' | 'packets_missing'>): string {
  const all = session.packets_stored + session.packets_missing;
  if (all === 0 || session.packets_missing / all < 0.01) return '';
  return t('session.loss', { percent: number((100 * session.packets_missing) / all, 1) });
}
