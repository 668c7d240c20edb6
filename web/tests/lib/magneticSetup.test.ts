import { expect, it } from 'vitest';
import {
  isForbidden,
  isSafe,
  placesOf,
  simulatedMovement,
  sourceParameters,
  USES,
  USUAL,
  wornFor,
} from '../../src/kinds/magnetic/magneticSetup';

it('wears the source on the pelvis and the sensors on the treated side, or one on each shoe', () => {
  expect(wornFor('leg', 'left')).toEqual({ source: 'pelvis', sensors: ['thigh_left'] });
  expect(wornFor('arm', 'right').sensors).toEqual(['upper_arm_right', 'hand_right']);
  expect(wornFor('feet', null)).toEqual({ source: 'foot_left', sensors: ['foot_right'] });
  for (const use of USES) expect(wornFor(use, 'both').sensors).not.toContain(wornFor(use, 'both').source);
});

it('tells the service what differs from its own defaults, in metres', () => {
  expect(sourceParameters(wornFor('back', null), USUAL)).toEqual({ source: 'pelvis' });
  expect(sourceParameters(wornFor('feet', null), USUAL)).toEqual({
    source: 'foot_left',
    coil_radius_m: 0.075,
    current_a: 1.36,
  });
  expect(
    sourceParameters(wornFor('back', null), { ...USUAL, radiusCm: 4, turns: 80, offsetCm: 0, currentA: 2 }),
  ).toEqual({
    source: 'pelvis',
    coil_radius_m: 0.04,
    coil_turns: 80,
    coil_offset_m: 0,
    current_a: 2,
    current_limit_a: 2,
  });
});

it('tells a winding that is not thin, and fires every coil in turn on a bench', () => {
  expect(sourceParameters(wornFor('back', null), { ...USUAL, lengthCm: 1.2 })).toEqual({
    source: 'pelvis',
    coil_length_m: 0.012,
    coil_depth_m: 0,
    coil_layers: [5, 3],
  });
  expect(sourceParameters(wornFor('bench', null), USUAL, 'bench')).toMatchObject({
    fixed_interval_s: 0.25,
    mounting_direction: [0, 0, 0],
  });
});

it('takes places in centimetres, leaves empty stops out, and waits for six whole ones', () => {
  const five: [number, number, number][] = [1, 2, 3, 4, 5].map((n) => [10 * n, 0, -5]);
  expect(placesOf(five)).toBeNull();
  expect(placesOf([...five, [1, null, 2]])).toBeNull();
  expect(placesOf([...five, [null, null, null], [20, 1, 2]])?.slice(4)).toEqual([
    [0.5, 0, -0.05],
    null,
    [0.2, 0.01, 0.02],
  ]);
});

it('takes two answers of no for safe, and one other for forbidden', () => {
  expect(isSafe({ patient: 'none', nearby: 'none' })).toBe(true);
  expect(isSafe({ patient: 'none', nearby: '' })).toBe(false);
  expect(isForbidden({ patient: 'none', nearby: '' })).toBe(false);
  expect(isForbidden({ patient: 'none', nearby: 'some' })).toBe(true);
});

it('simulates what comes nearest', () => {
  expect(simulatedMovement(['pelvis', 'sternum'])).toBe('flexion');
  expect(simulatedMovement(['foot_left', 'foot_right'])).toBe('feet');
  expect(simulatedMovement(['pelvis', 'hand_left'])).toBe('shoulder');
});
