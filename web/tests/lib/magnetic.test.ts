import { describe, expect, it } from 'vitest';
import { channelLabel } from '../../src/lib/channels';
import {
  needsHand,
  pairOf,
  pulsesIn,
  stateKeys,
  hasSigma,
  isStarting,
  sigmaOf,
} from '../../src/kinds/magnetic/magnetic';
import { spreadOf } from '../../src/lib/spread';

describe('flags of a magnetic session', () => {
  it('says one thing while it starts, and what needs a hand first afterwards', () => {
    expect(stateKeys(1 | 2 | 4)).toEqual(['magnetic.flag.calibrating']);
    expect(needsHand(1 | 2 | 4)).toBe(false);
    expect(stateKeys(0)).toEqual(['magnetic.sound']);
    expect(stateKeys(4 | 16 | 128)).toEqual([
      'magnetic.flag.missing',
      'magnetic.flag.inertial',
      'magnetic.flag.uncertain',
    ]);
    expect(stateKeys(1 | 4 | 64)).toEqual(['magnetic.none', 'magnetic.flag.fault']);
    expect(needsHand(4 | 64)).toBe(true);
    expect(needsHand(128)).toBe(false);
  });
});

describe('pulses', () => {
  it('are found with their coil, length and current', () => {
    const time = [0, 1, 2, 3, 4, 5, 6, 7].map((one) => one / 100);
    const found = pulsesIn(time, [0, 2, 2, 0, 1, 3, 3, 3], [0, 1.3, 1.3, 0, 0.5, 1, 1, 1]);
    expect(
      found.map((one) => [one.coil, one.startS, Math.round(1000 * (one.endS - one.startS)), one.currentA]),
    ).toEqual([
      [2, 0.01, 20, 1.3],
      [1, 0.04, 10, 0.5],
      [3, 0.05, 30, 1],
    ]);
    expect(pulsesIn([], [], [])).toEqual([]);
  });
});

describe('names', () => {
  it('tell source and sensor apart though both have underscores', () => {
    expect(pairOf('pelvis_upper_arm_left')).toEqual({ source: 'pelvis', sensor: 'upper_arm_left' });
    expect(pairOf('foot_left_foot_right')).toEqual({ source: 'foot_left', sensor: 'foot_right' });
    expect(pairOf('pelvis')).toBeNull();
  });
  it('are plain words', () => {
    expect(channelLabel('foot_left_foot_right_zyx_flexion')).toMatchObject({
      text: 'Bend forward, Right foot',
      unit: 'rad',
    });
    expect(channelLabel('upper_arm_left_distance_m')).toMatchObject({ text: 'Distance, Left upper arm', unit: 'm' });
  });
});

it('an accuracy is told by its median and its worst', () => {
  expect(spreadOf([null, 3, 1, 2])).toEqual({ median: 2, worst: 3 });
  expect(spreadOf([null])).toBeNull();
});

it('finds the band of a distance in its own column, and says what has none', () => {
  expect(sigmaOf('upper_arm_left_distance_m')).toBe('upper_arm_left_distance_sigma_m');
  expect(sigmaOf('pelvis_sternum_zyx_flexion')).toBe('pelvis_sternum_zyx_flexion.sigma');
  expect(hasSigma('foot_left_speed_mps')).toBe(false);
  expect(hasSigma('sternum_distance_m')).toBe(true);
});
it('knows when the first position is still to come', () => {
  expect(isStarting(2)).toBe(true);
  expect(isStarting(4)).toBe(false);
});
