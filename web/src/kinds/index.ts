// The kinds of session, a folder each; found by the name that the service gives them.
import type { SessionDetail } from '../api/types';
import type { Near } from '../components/CameraBar';
import { isOfLegs } from '../lib/placements';
import type { SessionKind } from './kind';

/** By the path of their file. */
export const MANIFESTS = import.meta.glob<SessionKind>('./*/manifest.ts', { eager: true, import: 'kind' });
export const KINDS: readonly SessionKind[] = Object.values(MANIFESTS).sort((one, other) => one.rank - other.rank);

/** The kind with which an exercise is done. */
export function kindFor(movement: string | undefined): SessionKind {
  return KINDS.find((kind) => kind.begin?.suits?.(movement)) ?? KINDS[0]!;
}

/** What the nearest point of view shows of a session. */
export function nearOf(session: Pick<SessionDetail, 'pipeline' | 'placements'>): Near {
  const { near } = kindOf(session);
  return near === 'arm' && isOfLegs(session.placements) ? 'leg' : near;
}

/** The kind of a session; one that this client does not know shows what arms do. */
export function kindOf({ pipeline }: Pick<SessionDetail, 'pipeline'>): SessionKind {
  const named = (name: string) => KINDS.find((kind) => kind.pipeline === name);
  return named(pipeline) ?? named('arm')!;
}
