import { expect, it } from 'vitest';
import { isForbidden, isSafe, simulatedMovement, sourceParameters, USES, USUAL, wornFor } from '../../src/lib/magneticSetup';

it('wears the source on the pelvis and the sensors on the treated side, or one on each shoe', () => {
  expect(wornFor('leg', 'left')).toEqual({ source: 'pelvis', sensors: ['thigh_left'] });
  expect(wornFor('arm', 'right').sensors).toEqual(['upper_arm_right', 'hand_right']);
  expect(wornFor('feet', null)).toEqual({ source: 'foot_left', sensors: ['foot_right'] });
  for (const use of USES) expect(wornFor(use, 'both').sensors).not.toContain(wornFor(use, 'both').source);
});

it('tells the service what differs from its own defaults, in metres', () => {
  expect(sourceParameters(wornFor('back', null), USUAL)).toEqual({ source: 'pelvis' });
  expect(sourceParameters(wornFor('feet', null), USUAL)).toEqual({ source: 'foot_left', coil_radius_m: 0.075, current_a: 1.36 });
  expect(sourceParameters(wornFor('back', null), { radiusCm: 4, turns: 80, offsetCm: 0, currentA: 2 })).toEqual({
    source: 'pelvis',
    coil_radius_m: 0.04,
    coil_turns: 80,
    coil_offset_m: 0,
    current_a: 2,
    current_limit_a: 2,
  });
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
