// What may be said of a change: never a change that shows as none.
import { expect, it } from 'vitest';
import { courseRows } from '../../src/lib/assessment/course';
import { isSure, trendShort, trendText } from '../../src/lib/assessment/trend';
import { plainProgress } from '../../src/lib/plain';
import type { ProgressMeasure } from '../../src/api/types';
import { changed } from '../trend';

const of = (measure: string, unit: string, trend: ProgressMeasure['trend']) =>
  ({ measure, label: measure, unit, points: [{ at: trend.since }], trend, bands: [] }) as unknown as ProgressMeasure;

it('is the difference of what is shown beside it', () => {
  const share = of('duration_ratio', '%', changed(4.4, 2.4, 1));
  expect(trendShort(share)).toMatch(/^−2 percentage points ± 1/);
  expect(isSure(share)).toBe(true);
});

it.each([
  ['joint_common_share', '%', changed(99.98, 99.999, 0.01)],
  ['joint_correlation', '1', changed(-0.9999, -0.99999, 0.00001)],
  ['range:humerus_forearm_right_zxy_flexion', 'rad', changed(1, 1.001, 0.0005)],
])('of %s is not called one where both levels show the same number', (measure, unit, trend) => {
  const one = of(measure, unit, trend);
  expect(isSure(one)).toBe(false);
  expect(trendShort(one)).toMatch(/^unchanged: within ± /);
  expect(trendText(one)).not.toContain('a week');
  // It does not come before what has changed.
  const other = of('peak_speed', 'm/s', changed(0.2, 0.4, 0.05));
  const first = of('duration', 's', changed(5, 3, 1));
  if (measure.startsWith('range:')) {
    expect(courseRows([first, one, other]).map((row) => row.measure)).toEqual(['duration', 'peak_speed', measure]);
    expect(plainProgress(one)).toBe(plainProgress(of(measure, unit, { ...trend, word: 'unchanged' })));
  }
});
