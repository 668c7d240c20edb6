import type { ComparisonDetail, PhaseCurve } from '../../api/types';
import { extent } from '../../charts/scales';
import { zeroOf } from '../channels';
import { limbOf } from '../placements';

type Values = readonly (number | null)[];

/** The same curve counted from where clinicians begin (`zeroOf`), for drawing. */
export function aboutZero(curve: PhaseCurve): PhaseCurve {
  const zero = zeroOf(curve.channel) * (curve.unit === 'rad' ? 1 : 180 / Math.PI);
  if (zero === 0) return curve;
  const less = (values: Values): (number | null)[] => values.map((value) => (value === null ? null : value - zero));
  return {
    ...curve,
    mean: less(curve.mean),
    low: less(curve.low),
    high: less(curve.high),
    repetitions: curve.repetitions.map(less),
  };
}

/**
 * Both edges of a curve's band for drawing: where the therapist left it free it reaches to the rim of all that is drawn,
 * and a gap in the recording stays a gap.
 */
export function bandEdges(curve: PhaseCurve): { low: (number | null)[]; high: (number | null)[] } {
  const rim = extent(curve.mean, curve.low, curve.high, ...curve.repetitions) ?? [0, 1];
  const edge = (values: Values, free: number) =>
    values.map((value, index) => value ?? (typeof curve.width?.[index] === 'number' ? free : null));
  return { low: edge(curve.low, rim[0]), high: edge(curve.high, rim[1]) };
}

/** Whether the repetitions of a comparison are the strides of a walk. */
export const isOfStrides = (comparison: ComparisonDetail | null): boolean =>
  limbOf(comparison?.curves[0]?.channel) === 'foot';

export interface OutsideStretch {
  /** Position in the comparison's repetitions. */
  repetition: number;
  /** The repetition's own number. */
  number: number;
  from: number;
  until: number;
}

/** Every stretch of a channel outside the band in the repetitions that count, the longest first. */
export function outsideOf(comparison: ComparisonDetail, channel: string): OutsideStretch[] {
  return comparison.repetitions
    .flatMap((one, repetition) =>
      one.repetition.is_kept
        ? (one.outside_band[channel] ?? []).map(([from, until]) => ({
            repetition,
            number: one.repetition.number,
            from,
            until,
          }))
        : [],
    )
    .sort((a, b) => b.until - b.from - (a.until - a.from));
}

const FIRST = 3;

/** The channel whose range is the main measure: the one that the summary relates to the template. */
export function primaryChannel(summary: readonly { measure: string }[]): string | null {
  return summary.find((one) => one.measure.startsWith('range_ratio:'))?.measure.slice('range_ratio:'.length) ?? null;
}

/**
 * The curves to show: the main one, then those that leave the band most, positions of points last.
 * `outsideLength` says how long a channel is outside, over all repetitions.
 */
export function pickCurves(
  curves: readonly PhaseCurve[],
  all: boolean,
  primary: string | null = null,
  outsideLength: (channel: string) => number = () => 0,
): PhaseCurve[] {
  const rank = (curve: PhaseCurve) => (curve.channel === primary ? 0 : curve.channel.includes('.') ? 2 : 1);
  const ordered = curves
    .filter((curve) => curve.mean.some((value) => value !== null && Number.isFinite(value)))
    .sort((a, b) => rank(a) - rank(b) || outsideLength(b.channel) - outsideLength(a.channel));
  return all ? ordered : ordered.slice(0, FIRST);
}
