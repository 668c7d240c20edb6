// The kinds of session, a folder each; found by the name that the service gives them.
import type { SessionDetail } from '../api/types';
import { arm } from './arm/facts';
import type { SessionKind } from './kind';
import { magnetic } from './magnetic/facts';
import { walk } from './walk/facts';

const KINDS: readonly SessionKind[] = [arm, walk, magnetic];

/** The kind of a session; single sensors that nobody wears show what arms do, with less in it. */
export function kindOf({ pipeline }: Pick<SessionDetail, 'pipeline'>): SessionKind {
  return KINDS.find((kind) => kind.pipeline === pipeline) ?? arm;
}
