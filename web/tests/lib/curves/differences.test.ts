import { expect, it } from 'vitest';
import type { Differences, Result } from '../../../src/api/types';
import { differenceRows, distinctResults, overallRms } from '../../../src/lib/assessment/differences';

const result = (id: string, orientation: string, change: Partial<Result> = {}): Result => ({
  id,
  kind: 'offline',
  pipeline: 'arm',
  pipeline_version: '1',
  orientation,
  orientation_version: '1',
  orientation_parameters: {},
  status: 'complete',
  progress: 1,
  message: '',
  created_at: '',
  ...change,
});
const angle = (name: string, rms: number | null, compared = 10) => ({
  name,
  rms_deg: rms,
  mean_deg: 0,
  maximum_deg: rms,
  maximum_at_s: 1,
  compared_s: compared,
});
const apart = (angles: Differences['angles']): Differences => ({
  result_a: result('a', 'x'),
  result_b: result('b', 'y'),
  angles,
  segments: [],
  time_s: [],
  curves: [],
});

it('puts the angle that differs most first, and says where nothing could be compared', () => {
  const rows = differenceRows([
    apart([angle('one', 1), angle('two', 4)]),
    apart([angle('one', 2), angle('two', null)]),
    undefined,
  ]);
  expect(rows.map((row) => [row.name, row.rms])).toEqual([
    ['two', [4, null, null]],
    ['one', [1, 2, null]],
  ]);
});

it('weighs angles by the time that could be compared', () => {
  expect(overallRms(apart([angle('one', 3, 10), angle('two', 4, 10), angle('three', null, 0)]))).toBeCloseTo(
    Math.sqrt(12.5),
  );
  expect(overallRms(undefined)).toBeNull();
});

it('keeps one result of each kind, the main one before others', () => {
  const kept = distinctResults(
    [
      result('main', 'vqf'),
      result('again', 'vqf'),
      result('live', 'vqf', { kind: 'live' }),
      result('other', 'ekf', { status: 'failed' }),
    ],
    'main',
  );
  expect(kept.map((one) => one.id)).toEqual(['main', 'live']);
});
