// What may be said of a change, in words: one mechanism for the panel, both reports and the patient's pages. Numbers are
// rounded once: a change that is shown is the difference of the levels that are shown.
import type { ProgressMeasure } from '../../api/types';
import { t } from '../../i18n';
import { date, difference, displayUnit, number, quantity, span, spreadAlone } from '../format';

export type Trend = ProgressMeasure['trend'];

/** Both levels and their difference as they are shown, in the unit of the measure; null where nothing may be said. */
export function shownChange(trend: Trend, unit: string): { start: number; now: number; change: number } | null {
  if (typeof trend.start !== 'number' || typeof trend.now !== 'number') return null;
  const { factor, digits } = displayUnit(unit);
  const rounded = (value: number) => Number((value * factor).toFixed(digits)) / factor;
  const start = rounded(trend.start);
  const now = rounded(trend.now);
  // The subtraction itself must not add digits of its own.
  return { start, now, change: rounded(now - start) };
}

/** `+15° ± 3`. */
function changeOf(trend: Trend, unit: string): string {
  const { factor, digits } = displayUnit(unit);
  const change = shownChange(trend, unit)?.change ?? 0;
  const half = spreadAlone((trend.half_width ?? 0) * factor, digits);
  return t('trend.change', { change: difference(change, unit), half });
}

type Judged = Pick<ProgressMeasure, 'trend' | 'unit'>;

/** A change that is smaller than the last digit that is shown is none for who reads it. */
const isTooSmallToShow = ({ trend, unit }: Judged) => shownChange(trend, unit)?.change === 0;

/** Whether a change is said for sure. */
export const isSure = (measure: Judged) =>
  ['more', 'less', 'a_little_more', 'a_little_less'].includes(measure.trend.word) && !isTooSmallToShow(measure);

/** For a cell of a table. */
export function trendShort(measure: Judged): string {
  const { trend, unit } = measure;
  const change = changeOf(trend, unit);
  const within = () =>
    t('trend.unchanged', { within: span(Math.abs(trend.change ?? 0) + (trend.half_width ?? 0), unit) });
  if (trend.word !== 'values' && trend.word !== 'unknown' && isTooSmallToShow(measure)) return within();
  switch (trend.word) {
    case 'values':
      return t('trend.values', { count: trend.days });
    case 'more':
    case 'less':
      return change;
    case 'a_little_more':
    case 'a_little_less':
      return t('trend.little', { change, important: span(trend.important, unit) });
    case 'probably_more':
      return t('trend.probablyMore', { change });
    case 'probably_less':
      return t('trend.probablyLess', { change });
    case 'unchanged':
      return within();
    case 'unknown':
      return t('trend.unknown', { half: span(trend.half_width, unit) });
  }
}

/** The same with the day of the baseline, and how much that is in a week. */
export function trendText(measure: Pick<ProgressMeasure, 'trend' | 'unit'>): string {
  const { trend, unit } = measure;
  const words = trendShort(measure);
  if (trend.word === 'values') return words;
  const since = date(trend.since);
  if (!isSure(measure) || typeof trend.per_week !== 'number') return t('trend.since', { words, since });
  const { factor, digits, suffix } = displayUnit(unit);
  const weekly = `${number(Math.abs(trend.per_week * factor), digits + 1)}${suffix}`;
  return t('trend.sinceWeekly', { words, since, weekly });
}

/** What stands beside it: an unusual last day, where the series breaks, and by what it was judged. */
export function trendNotes(measure: Pick<ProgressMeasure, 'trend' | 'unit'>): string[] {
  const { trend, unit } = measure;
  const notes = trend.breaks.map((one) => t(`trend.break.${one.kind}`, { date: date(one.at) }));
  if (trend.is_last_day_unusual) notes.unshift(t('trend.unusual', { expected: quantity(trend.expected, unit) }));
  return notes;
}

/** By what a change is judged: how much sessions differ, whose it is, and what was published as important. */
export function judgedBy({ trend, unit }: Pick<ProgressMeasure, 'trend' | 'unit'>): string {
  if (typeof trend.scatter !== 'number') return '';
  const words = {
    scatter: span(trend.scatter, unit),
    limit: span(trend.minimal_detectable_change, unit),
    count: trend.scatter_people,
    source: trend.scatter_source,
  };
  const said = [
    trend.scatter_source
      ? t('trend.scatterPublished', words)
      : trend.scatter_people > 0
        ? t('trend.scatterClinic', words)
        : t('trend.scatterOwn', words),
  ];
  if (trend.important_source)
    said.push(t('trend.important', { important: span(trend.important, unit), source: trend.important_source }));
  return said.join(' ');
}
