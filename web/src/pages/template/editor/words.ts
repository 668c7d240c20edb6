// What phases, cues and stops are called in a sentence.
import type { CueDesign, StopDesign } from '../../../api/types';
import { formatLocale, t, withinSentence } from '../../../i18n';
import { wordsOf } from '../../../i18n/codes';
import type { PhaseDraft } from '../../../lib/assessment/design';
import { channelLabel } from '../../../lib/channels';
import { subjectOf } from '../../../lib/editing/designFields';
import type { Merge } from '../../../lib/editing/merge';
import { number, plainTick, quantity } from '../../../lib/format';

/** The name of a phase, or which one it is. */
export function phaseName(phases: readonly PhaseDraft[], index: number): string {
  const name = phases[index]?.name.trim();
  if (name) return name;
  return phases.length === 1 ? t('design.whole') : t('design.phaseNumber', { number: index + 1 });
}

/** What a cue says to the patient. */
export function cueSays(cue: CueDesign): string {
  return cue.words?.trim() || wordsOf(cue.sentence);
}

/** The unit of a curve by its name. */
export function unitOf(channel: string): 'm' | 'rad' {
  return channel.includes('.') || channel.endsWith('_m') ? 'm' : 'rad';
}

/** When a cue is said, as a half sentence after “When”. */
export function cueWhen(cue: CueDesign): string {
  const curve = withinSentence(channelLabel(cue.channel ?? '').text);
  if (cue.quantity === 'deviation' && cue.tolerance == null)
    return t(`design.when.band.${cue.side ?? 'both'}`, { curve });
  if (cue.quantity === 'deviation')
    return t(`design.when.off.${cue.side ?? 'both'}`, {
      curve,
      by: quantity(cue.tolerance, unitOf(cue.channel ?? '')),
    });
  if (cue.quantity === 'at_equal')
    return t(`design.when.plane.${cue.side ?? 'both'}`, { by: quantity(cue.tolerance, 'rad') });
  if (cue.quantity === 'range') return t('design.when.range', { share: number(100 * (cue.tolerance ?? 0)) });
  return t(`design.when.${cue.quantity}`, { times: plainTick(cue.tolerance ?? 0, 2) });
}

const MINUTE_S = 60;

/** What a stop rule is called, by the field of a design that it is. */
export function stopName(field: string): string {
  const [kind = '', channel = '', side = ''] = subjectOf(field).split('|');
  if (kind === 'limit')
    return t(side === 'below' ? 'meanwhile.limitbelow' : 'meanwhile.limitabove', { curve: channelLabel(channel).text });
  if (kind === 'lost' || kind === 'unsure') return t(`meanwhile.stop.${kind}`);
  return t(`design.stop.${kind as 'valid_count' | 'attempt_count' | 'time' | 'wrong_in_a_row'}`);
}

/** Where a stop rule stops; of a limit also after how long beyond it. */
export function stopText(one: StopDesign): string {
  const limit = one.limit ?? 0;
  if (one.kind === 'limit') {
    const value = quantity(limit, unitOf(one.channel ?? ''));
    return one.hold_s
      ? t('meanwhile.held', { limit: value, hold: number(one.hold_s, one.hold_s % 1 ? 2 : 0) })
      : t('meanwhile.atOnce', { limit: value });
  }
  if (one.kind === 'time')
    return t('meanwhile.minutes', { minutes: number(limit / MINUTE_S, limit % MINUTE_S ? 1 : 0) });
  if (one.kind === 'lost' || one.kind === 'unsure') return quantity(one.hold_s, 's');
  return number(limit);
}

/** The rules of what was opened that this person deleted, and that go when both changes are taken. */
export function removedStops(merge: Merge): string[] {
  return merge.mineRemoved
    .filter(({ field }) => field.startsWith('stop:'))
    .map(({ field, before }) =>
      t('meanwhile.removed', { rule: stopName(field), value: stopText(before as StopDesign) }),
    );
}

/** Several names as one phrase, each once. */
export function namesOf(people: readonly string[]): string {
  return new Intl.ListFormat(formatLocale(), { type: 'conjunction' }).format(new Set(people));
}
