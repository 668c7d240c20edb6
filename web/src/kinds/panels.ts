// What the pages of a session show of its kind.
import type { SessionDetail } from '../api/types';
import { FACTS, kindOf } from '.';
import type { KindParts } from './kind';

const PARTS = import.meta.glob<KindParts>('./*/parts.tsx', { eager: true, import: 'parts' });

/** The components of a session's kind. */
export function partsOf(session: Pick<SessionDetail, 'pipeline'>): KindParts {
  const kind = kindOf(session);
  const folder = Object.keys(FACTS).find((path) => FACTS[path] === kind) ?? '';
  return PARTS[folder.replace('facts.ts', 'parts.tsx')]!;
}
