// What the pages of a session show of its kind.
import type { SessionDetail } from '../api/types';
import { kindOf } from '.';
import { arm } from './arm/facts';
import { parts as armParts } from './arm/parts';
import type { KindParts, SessionKind } from './kind';
import { magnetic } from './magnetic/facts';
import { parts as magneticParts } from './magnetic/parts';
import { walk } from './walk/facts';
import { parts as walkParts } from './walk/parts';

const PARTS = new Map<SessionKind, KindParts>([
  [arm, armParts],
  [walk, walkParts],
  [magnetic, magneticParts],
]);

/** The components of a session's kind. */
export function partsOf(session: Pick<SessionDetail, 'pipeline'>): KindParts {
  return PARTS.get(kindOf(session)) ?? armParts;
}
