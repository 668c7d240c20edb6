// What the pages of a session show of its kind.
import type { SessionDetail } from '../api/types';
import { kindOf } from '.';
import { parts as arm } from './arm/parts';
import type { KindParts } from './kind';
import { parts as magnetic } from './magnetic/parts';
import { parts as walk } from './walk/parts';

const PARTS: Record<string, KindParts> = { arm, gait: walk, relative_pose: magnetic };

/** The components of a session's kind. */
export function partsOf(session: Pick<SessionDetail, 'pipeline'>): KindParts {
  return PARTS[kindOf(session).pipeline] ?? arm;
}
