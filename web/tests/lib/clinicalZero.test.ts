import { describe, expect, it } from 'vitest';
import type { PhaseCurve } from '../../src/api/types';
import { isMeaningful } from '../../src/charts/Traces';
import { aboutZero } from '../../src/lib/assessment/comparison';
import { channelLabel, zeroOf } from '../../src/lib/channels';

const SINGULAR = 128;
const curve = (channel: string, unit: string): PhaseCurve =>
  ({
    channel,
    label: channel,
    unit,
    mean: [90, null],
    low: [80, null],
    high: [100, 126],
    repetitions: [[126, null]],
  }) as PhaseCurve;

describe('what clinicians call zero', () => {
  it('is the neutral forearm, on both sides, and of nothing else', () => {
    for (const side of ['left', 'right']) {
      expect(zeroOf(`humerus_forearm_${side}_zxy_pronation`)).toBeCloseTo(Math.PI / 2);
      expect(channelLabel(`humerus_forearm_${side}_zxy_pronation`).zero).toBeCloseTo(Math.PI / 2);
      expect(zeroOf(`humerus_forearm_${side}_zxy_flexion`)).toBe(0);
    }
    expect(zeroOf('trunk_lean_forward_rad')).toBe(0);
  });

  it('is taken off every line of a curve, gaps stay gaps', () => {
    const shown = aboutZero(curve('humerus_forearm_right_zxy_pronation', 'deg'));
    expect([shown.mean, shown.low, shown.high, shown.repetitions]).toEqual([
      [0, null],
      [-10, null],
      [10, 36],
      [[36, null]],
    ]);
    const elbow = curve('humerus_forearm_right_zxy_flexion', 'deg');
    expect(aboutZero(elbow)).toBe(elbow);
  });
});

describe('the number beside a curve', () => {
  it('stands only where the angle has a meaning and is known', () => {
    const degrees = Math.PI / 180;
    expect(isMeaningful(0, 3 * degrees, 'rad')).toBe(true);
    expect(isMeaningful(0, NaN, 'rad')).toBe(true);
    expect(isMeaningful(SINGULAR, 3 * degrees, 'rad')).toBe(false);
    expect(isMeaningful(1, NaN, 'm')).toBe(false);
    expect(isMeaningful(256 | 4 | 32, 10 * degrees, 'rad')).toBe(false);
    expect(isMeaningful(4 | 32, 10 * degrees, 'rad')).toBe(true);
    expect(isMeaningful(32, 10 * degrees, 'rad')).toBe(true);
    expect(isMeaningful(0, 20 * degrees, 'rad')).toBe(false);
    expect(isMeaningful(0, 0.5, 'm')).toBe(true);
  });
});
