// The rows of the report of a course: baseline, newest session, change, and what may be said of it.
import type { ProgressMeasure } from '../../api/types';
import { BASELINE } from './baseline';

export interface CourseRow {
  measure: ProgressMeasure;
  /** Mean of the first sessions, at most three. */
  baseline: number;
  baselineSessions: number;
  newest: number;
  newestCount: number;
  sessions: number;
  /** Of the newest session against the baseline, as the report of that session has it: what the two values beside it give. */
  change: number | null;
  isReal: boolean | null;
}

const MOST_ROWS = 9;

/** What is said first: the main measure as it comes, then compensation, then whatever changed for sure. */
export function courseRows(measures: readonly ProgressMeasure[], most = MOST_ROWS): CourseRow[] {
  const rank = (one: ProgressMeasure, index: number) =>
    index === 0 ? 0 : one.measure.startsWith('compensation:') ? 1 : one.points.at(-1)?.is_real_change ? 2 : 3;
  return measures
    .filter((one) => one.points.length > 0)
    .map((measure, index) => ({ measure, rank: rank(measure, index), index }))
    .sort((a, b) => a.rank - b.rank || a.index - b.index)
    .slice(0, most)
    .map(({ measure }) => {
      const first = measure.points.slice(0, BASELINE);
      const last = measure.points.at(-1);
      return {
        measure,
        baseline: first.reduce((sum, point) => sum + point.value, 0) / first.length,
        baselineSessions: first.length,
        newest: last?.value ?? NaN,
        newestCount: last?.count ?? 0,
        sessions: measure.points.length,
        change: last?.change ?? null,
        isReal: last?.is_real_change ?? null,
      };
    });
}
