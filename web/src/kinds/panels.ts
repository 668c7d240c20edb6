// What the pages of a session show of its kind.
import type { SessionDetail } from '../api/types';
import { MANIFESTS, kindOf } from '.';
import type { KindPanels } from './kind';

const PANELS = import.meta.glob<KindPanels>('./*/panels.tsx', { eager: true, import: 'panels' });

/** The components of a session's kind. */
export function panelsOf(session: Pick<SessionDetail, 'pipeline'>): KindPanels {
  const kind = kindOf(session);
  const folder = Object.keys(MANIFESTS).find((path) => MANIFESTS[path] === kind) ?? '';
  return PANELS[folder.replace('manifest.ts', 'panels.tsx')]!;
}
