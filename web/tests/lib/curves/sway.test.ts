// Lean and sway of a live balance test, and its measures in the units of a clinic.
import { describe, expect, it } from 'vitest';
import { levelled, measureText, rootMeanSquare } from '../../../src/kinds/balance/sway';

describe('sway', () => {
  it('levels the axes by the mean lean, so that an error of the orientation cancels', () => {
    const time = Array.from({ length: 1000 }, (_, index) => index / 100);
    const lean = time.map((at) => 0.1 + 0.006 * Math.sin(2 * at));
    const pushed = time.map((at) => -0.9 * 4 * 0.006 * Math.sin(2 * at));
    const zero = time.map(() => 0);
    const [forward] = levelled({ forward: lean, left: zero, pushedForward: pushed, pushedLeft: zero, window: 1 });
    const [wrong] = levelled({
      forward: lean.map((one) => one + 0.01),
      left: zero,
      pushedForward: pushed,
      pushedLeft: zero,
      window: 1,
    });
    expect(rootMeanSquare([forward])).toBeCloseTo(((9.80665 + 3.6) * 0.006) / Math.SQRT2, 2);
    expect(rootMeanSquare([wrong])).toBeCloseTo(rootMeanSquare([forward]), 4);
  });

  it('writes measures with their uncertainty', () => {
    expect(measureText({ measure: 'ellipse_area', value: 0.000367, sigma: 0.00005, unit: 'm^2' })).toBe(
      '3.7 ± 0.5 cm²',
    );
    expect(measureText({ measure: 'reach_displacement', value: 0.23, sigma: 0.01, unit: 'm' })).toBe('23.0 ± 1.0 cm');
    expect(measureText({ measure: 'x', value: null, sigma: null, unit: 'm' })).toBe('–');
    expect(measureText(undefined)).toBe('–');
  });
});
