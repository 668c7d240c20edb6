import type { ComparisonDetail, PhaseCurve } from '../api/types';

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
        ? (one.outside_band[channel] ?? []).map(([from, until]) => ({ repetition, number: one.repetition.number, from, until }))
        : [],
    )
    .sort((a, b) => b.until - b.from - (a.until - a.from));
}

const FIRST = 3;

/** The curves to show: first the service's own order of joint angles and trunk; positions of points come last. */
export function pickCurves(curves: readonly PhaseCurve[], all: boolean): PhaseCurve[] {
  const drawable = curves.filter((curve) => curve.mean.some((value) => value !== null && Number.isFinite(value)));
  const angles = drawable.filter((curve) => !curve.channel.includes('.'));
  const points = drawable.filter((curve) => curve.channel.includes('.'));
  const ordered = [...angles, ...points];
  return all ? ordered : ordered.slice(0, FIRST);
}
