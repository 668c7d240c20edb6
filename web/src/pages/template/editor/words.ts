// What phases, cues and stops are called in a sentence.
import type { CueDesign } from '../../../api/types';
import { t, withinSentence } from '../../../i18n';
import { wordsOf } from '../../../i18n/codes';
import type { PhaseDraft } from '../../../lib/assessment/design';
import { channelLabel } from '../../../lib/channels';
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
