import type { SessionEvent } from '../api/types';
import { t, tOr } from '../i18n';

/** What happened, in words: a change of state by its name, everything else as the service says it. */
export function eventText(event: SessionEvent): string {
  if (event.text) return tOr(`sessionState.${event.text}`, event.text);
  return tOr(`event.${event.kind}`, t('event.unnamed'));
}
