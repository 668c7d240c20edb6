import type { GuidanceMessage, SessionDetail } from '../../../api/types';

/** Whether she stopped because it hurt, as the time line or the guidance says it. */
export function hasHurt(session: SessionDetail, guidance: GuidanceMessage | null): boolean {
  return guidance?.cause === 'pain' || session.events.some((one) => one.kind === 'pain');
}
