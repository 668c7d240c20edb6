import type { SessionEvent } from '../api/types';
import { t, tOr } from '../i18n';
import { placementLabel } from './channels';

/** What happened, in words: a change of state by its name, everything else as the service says it. */
export function eventText(event: SessionEvent): string {
  const { text, placement, kind } = event;
  if (!text) return tOr(`event.${kind}`, t('event.unnamed'));
  // The service names sensors as programs do.
  if (placement && text.startsWith(`${placement}: `))
    return `${placementLabel(placement)}: ${text.slice(placement.length + 2)}`;
  return tOr(`sessionState.${text}`, text);
}

/** Whether it says that sensors sat otherwise than was assumed, so that it belongs beside every number. */
export const isAboutSensors = (event: SessionEvent): boolean =>
  event.kind === 'sensor_slipped' || event.kind === 'calibration_checked';
