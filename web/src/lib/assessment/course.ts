// The rows of the report of a course: level at the baseline and now, and what may be said of the change.
import measures from '../../api/measures.json';
import type { ProgressMeasure } from '../../api/types';
import { isSure } from './trend';

const MOST_ROWS = 9;
const INDICES: readonly string[] = measures.indices;

/** Whether a measure is one for who studies movement: it stands on the last sheet. */
export const isIndex = (measure: string) =>
  INDICES.some((name) => (name.endsWith(':') ? measure.startsWith(name) : measure === name));

/** What is said first: the main measure as it comes, then compensation, then whatever changed for sure. */
export function courseRows(
  found: readonly ProgressMeasure[],
  { indices = false, most = MOST_ROWS }: { indices?: boolean; most?: number } = {},
): ProgressMeasure[] {
  const rank = (one: ProgressMeasure, index: number) =>
    index === 0 ? 0 : one.measure.startsWith('compensation:') ? 1 : isSure(one) ? 2 : 3;
  return found
    .filter((one) => one.points.length > 0 && isIndex(one.measure) === indices)
    .map((measure, index) => ({ measure, rank: rank(measure, index), index }))
    .sort((a, b) => a.rank - b.rank || a.index - b.index)
    .slice(0, most)
    .map(({ measure }) => measure);
}
