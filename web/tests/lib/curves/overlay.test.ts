// The template over live curves: the therapist's band at the phase where the patient stands, made wider as prescribed.
import { expect, it } from 'vitest';
import type { PhaseCurve } from '../../../src/api/types';
import { templateLive } from '../../../src/lib/assessment/overlay';

const RAD = Math.PI / 180;
const phases = Array.from({ length: 101 }, (_, phase) => phase);
const curve: PhaseCurve = {
  channel: 'elbow',
  label: 'Elbow',
  unit: 'rad',
  mean: phases.map((phase) => phase * RAD),
  // Narrow in the first half, free above in the second.
  low: phases.map((phase) => (phase - (phase < 50 ? 4 : 10)) * RAD),
  high: phases.map((phase) => (phase < 50 ? (phase + 4) * RAD : null)),
  width: phases.map(() => 4 * RAD),
  repetitions: [phases.map((phase) => phase * RAD)],
};

it('is the band of the phase, scaled by the prescription', () => {
  const at = templateLive([curve], 1.5, (timeS) => (timeS < 0 ? null : timeS));
  expect(at('elbow', 20)?.mean).toBeCloseTo(20);
  expect(at('elbow', 20)?.low).toBeCloseTo(14);
  expect(at('elbow', 20)?.high).toBeCloseTo(26);
  expect(at('elbow', 80)?.low).toBeCloseTo(65);
  expect(at('elbow', 80)?.high).toBeGreaterThan(99);
});

it('says nothing where the phase or the curve is not known', () => {
  const at = templateLive([curve], 1, (timeS) => (timeS < 0 ? null : timeS));
  expect(at('elbow', -1)).toBeNull();
  expect(at('wrist', 20)).toBeNull();
});
