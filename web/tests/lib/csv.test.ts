import { describe, expect, it } from 'vitest';
import type { GuessedColumn, GuessedMapping } from '../../src/api/types';
import { complete, mappingProblems, placed, signedColumn } from '../../src/lib/csv';

function signal(
  sensor: string,
  quantity: GuessedColumn['quantity'],
  placement: GuessedColumn['placement'] = null,
): GuessedColumn {
  return { sensor, quantity, placement, columns: ['x', 'y', 'z'], unit: quantity === 'gyroscope' ? 'rad/s' : 'm/s^2' };
}

function mapping(signals: GuessedColumn[], more: Partial<GuessedMapping> = {}): GuessedMapping {
  return { signals, time_column: 't', time_unit: 's', ...more };
}

const WHOLE = [signal('a', 'gyroscope'), signal('a', 'accelerometer')];

describe('what keeps a mapping from being sent', () => {
  it('is a placement on the body, which single sensors need not have', () => {
    expect(mappingProblems(mapping(WHOLE), true)).toEqual(['csv.needPlacement']);
    expect(complete(mapping(WHOLE), true)).toBeNull();
    expect(complete(mapping(WHOLE), false)).toEqual(mapping(WHOLE));
  });
  it('is a missing time, quantity, column, or one of them twice', () => {
    expect(mappingProblems(mapping([], { time_column: null, rate_hz: 100 }), true)).toEqual(['csv.needSignals']);
    expect(mappingProblems(mapping(WHOLE.slice(0, 1), { time_column: null }), false)).toEqual([
      'csv.needTime',
      'csv.needAccelerometer',
    ]);
    expect(mappingProblems(mapping([...WHOLE, ...WHOLE]), false)).toEqual(['csv.twice']);
    expect(
      mappingProblems(
        mapping([{ ...signal('a', 'gyroscope'), columns: ['x', '', 'z'] }, signal('a', 'accelerometer')]),
        false,
      ),
    ).toEqual(['csv.needColumns']);
  });
  it('is a counter without a rate', () => {
    const counted = mapping(WHOLE, { time_unit: 'count' });
    expect(mappingProblems(counted, false)).toEqual(['csv.needTime']);
    expect(mappingProblems({ ...counted, rate_hz: 100 }, false)).toEqual([]);
  });
  it('is a unit that neither heading nor numbers say', () => {
    const counts = mapping([signal('a', 'gyroscope'), { ...signal('a', 'accelerometer'), unit: null }]);
    expect(mappingProblems(counts, false)).toEqual(['csv.needUnit']);
  });
  it('is not that two sensors have the same quantities', () => {
    expect(mappingProblems(mapping([...WHOLE, signal('b', 'gyroscope'), signal('b', 'accelerometer')]), false)).toEqual(
      [],
    );
  });
});

describe('choosing a placement', () => {
  it('holds for all signals of the sensor and no other', () => {
    const two = mapping([...WHOLE, signal('b', 'gyroscope')]);
    expect(placed(two, two.signals[0] as GuessedColumn, 'head').signals.map((one) => one.placement)).toEqual([
      'head',
      'head',
      null,
    ]);
  });
});

describe('a signed axis', () => {
  it('is a minus before the name of a column, unless a column is called so', () => {
    expect(signedColumn('-acc_z', ['acc_z'])).toEqual({ column: 'acc_z', isTurned: true });
    expect(signedColumn('-acc_z', ['acc_z', '-acc_z'])).toEqual({ column: '-acc_z', isTurned: false });
    expect(signedColumn('acc_z', ['acc_z'])).toEqual({ column: 'acc_z', isTurned: false });
  });
});
