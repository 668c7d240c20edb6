import { describe, expect, it } from 'vitest';
import type { PhaseCurve, TemplateDesign } from '../../src/api/types';
import {
  bandsFor,
  designOf,
  draftOf,
  edgesOf,
  factorAt,
  knotsFor,
  suggestedBorders,
  withBand,
  withBorder,
  withoutPhase,
  withSplit,
} from '../../src/lib/assessment/design';

const DESIGN: TemplateDesign = {
  phases: [
    { name: 'Out', start: 0, end: 0.4 },
    { name: 'Back', start: 0.4, end: 1 },
  ],
};

describe('the band while it is drawn', () => {
  it('is read between knots as the service reads it', () => {
    // The numbers of the library's own test: straight lines, and free from one knot to the next.
    const knots = [
      { phase: 0.2, below: 1, above: 2 },
      { phase: 0.4, below: 1, above: 4 },
      { phase: 0.6, below: 0.5, above: null },
    ];
    expect([0, 0.2, 0.3, 0.4].map((at) => factorAt(knots, 'above', at))).toEqual([2, 2, 3, 4]);
    expect([0.41, 0.6, 1].map((at) => factorAt(knots, 'above', at))).toEqual([null, null, null]);
    expect([0.3, 0.5, 1].map((at) => factorAt(knots, 'below', at))).toEqual([1, 0.75, 0.5]);
  });

  it('is level inside a phase and follows its borders', () => {
    const drawn = withBand(draftOf(DESIGN), 'a', 0, 'above', 0.5);
    const moved = withBorder(drawn, 0, 0.6);
    for (const [draft, border] of [
      [drawn, 0.4],
      [moved, 0.6],
    ] as const) {
      const knots = knotsFor(draft, 'a');
      expect(factorAt(knots, 'above', 0)).toBe(0.5);
      expect(factorAt(knots, 'above', border - 0.02)).toBe(0.5);
      expect(factorAt(knots, 'above', border)).toBeCloseTo(0.75);
      expect(factorAt(knots, 'above', border + 0.02)).toBe(1);
      expect(factorAt(knots, 'below', 0.1)).toBe(1);
    }
    expect(withBorder(drawn, 0, -1).phases[0]?.end).toBe(0.04);
  });

  it('is stored and read back without a difference', () => {
    let draft = withBand(draftOf(DESIGN), 'a', 1, 'below', null);
    draft = withBand(draft, 'b', 0, 'above', 1);
    const design = designOf(draft);
    expect(design.tolerances?.map((one) => one.channel)).toEqual(['a']);
    expect(designOf(draftOf(design))).toEqual(design);
    expect(bandsFor(draftOf(design), 'a')).toEqual([
      { below: 1, above: 1 },
      { below: null, above: 1 },
    ]);
  });

  it('keeps knots of another hand until somebody draws on that curve', () => {
    const knots = [
      { phase: 0.5, below: 2, above: 2 },
      { phase: 0.9, below: 1, above: 3 },
    ];
    const draft = withBorder(draftOf({ ...DESIGN, tolerances: [{ channel: 'a', knots }] }), 0, 0.3);
    expect(designOf(draft).tolerances).toEqual([{ channel: 'a', knots }]);
    expect(designOf(withBand(draft, 'a', 0, 'above', 4)).tolerances?.[0]?.knots).toHaveLength(4);
  });

  it('divides a phase and takes one away with their bands', () => {
    const drawn = withBand(draftOf(DESIGN), 'a', 1, 'above', 3);
    const three = withSplit(drawn, 1, 'Rest');
    expect(three.phases).toEqual([
      { name: 'Out', end: 0.4 },
      { name: 'Back', end: 0.7 },
      { name: 'Rest', end: 1 },
    ]);
    expect(bandsFor(three, 'a').map((one) => one.above)).toEqual([1, 3, 3]);
    expect(bandsFor(withoutPhase(three, 0), 'a').map((one) => one.above)).toEqual([3, 3]);
    expect(withoutPhase(three, 2).phases.at(-1)?.end).toBe(1);
  });

  it('gives the edges in the units of the curve, and none where free', () => {
    const curve = {
      channel: 'a',
      unit: 'deg',
      mean: Array.from({ length: 101 }, () => 10),
      width: Array.from({ length: 101 }, () => 4),
    } as unknown as PhaseCurve;
    const { low, high } = edgesOf(curve, [{ phase: 0, below: null, above: 0.5 }]);
    expect(high[50]).toBe(12);
    expect(low[50]).toBe(null);
  });

  it('suggests phases where the movement turns or is held', () => {
    const peak = Array.from({ length: 101 }, (_, at) => Math.sin((Math.PI * at) / 100));
    // sin > 0.9 lasts from 36 to 64 % of the movement: that is a hold.
    expect(suggestedBorders(peak)).toEqual([0.36, 0.64]);
    const sharp = Array.from({ length: 101 }, (_, at) => 1 - Math.abs(at - 30) / 70);
    expect(suggestedBorders(sharp.map((value, at) => (at < 30 ? at / 30 : value)))).toEqual([0.3]);
    expect(suggestedBorders(Array.from({ length: 101 }, () => 1))).toEqual([]);
  });
});
