// What is said to a patient by how the exercise is done: the one place of the client that knows sitting from standing.
import type { Posture } from '../api/types';
import { t } from '../i18n';

/** What is said; `undefined` is an exercise that is not known (yet): nothing is claimed of it. */
export function forPosture(what: 'waiting' | 'ready' | 'upright', posture: Posture | undefined): string {
  return t(`posture.${what}.${posture ?? 'any'}`);
}
