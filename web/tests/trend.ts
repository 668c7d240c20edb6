// A trend for tests: what is not said is that of a patient of whom only values are known.
import type { ProgressMeasure } from '../src/api/types';

export const trend = (change: Partial<ProgressMeasure['trend']> = {}): ProgressMeasure['trend'] => ({
  word: 'values',
  since: '2026-01-01T10:00:00Z',
  until: '2026-02-12T10:00:00Z',
  days: 2,
  start: null,
  now: null,
  change: null,
  half_width: null,
  per_week: null,
  probability: null,
  important: null,
  important_source: '',
  scatter: null,
  scatter_people: 0,
  scatter_source: '',
  minimal_detectable_change: null,
  is_last_day_unusual: false,
  expected: null,
  breaks: [],
  ...change,
});

/** A change that is sure. */
export const changed = (start: number, now: number, half_width: number, more: Partial<ProgressMeasure['trend']> = {}) =>
  trend({
    word: now > start ? 'more' : 'less',
    days: 6,
    start,
    now,
    change: now - start,
    half_width,
    per_week: (now - start) / 6,
    probability: now > start ? 0.99 : 0.01,
    ...more,
  });
