// How it goes, in one sentence for the patient; where nothing may be said of a change, how far the last time went.
import type { ProgressMeasure } from '../../api/types';
import { t } from '../../i18n';
import { displayUnit, number, quantity } from '../../lib/format';
import { jointOf, mainMeasure, plainProgress, shortName } from '../../lib/plain';

export function HowItGoes({ measures }: { measures: readonly ProgressMeasure[] }) {
  const main = mainMeasure(measures);
  const said = plainProgress(main) ?? (main && lastTime(main));
  return said ? <p className="mine-say">{said}</p> : null;
}

function lastTime(measure: ProgressMeasure): string | null {
  const { factor, suffix } = displayUnit(measure.unit);
  const value = measure.points.at(-1)?.value;
  if (value === undefined) return null;
  if (suffix !== '°') return t('mine.ownValue', { name: shortName(measure), value: quantity(value, measure.unit) });
  return t('mine.lastTime', { joint: jointOf(measure.measure), degrees: number(value * factor) });
}
