// Limits that a template itself keeps: what the service refuses is said before anything is sent (`estimators/guidance/_limits.py`).
import type { PhaseCurve, StopDesign } from '../../api/types';

const DEGREE = Math.PI / 180;
/** A rule stops two standard deviations before its limit. */
const ROOM = { rad: 3 * DEGREE, m: 0.012 };
const MARGIN = { rad: 10 * DEGREE, m: 0.05 };
const STEP = { rad: 5 * DEGREE, m: 0.01 };

type Side = 'above' | 'below';
const signOf = (side: Side) => (side === 'above' ? 1 : -1);
const unitOf = (curve: PhaseCurve) => (curve.unit === 'm' ? 'm' : 'rad');

/** The value of a curve nearest to a limit of a side, or beyond it, rad or m: over its mean and what counts of its recording. */
export function farthest(curve: PhaseCurve, side: Side, left: ReadonlySet<number>): number | null {
  const factor = unitOf(curve) === 'm' ? 1 : DEGREE;
  const known = [curve.mean, ...curve.repetitions.filter((_, index) => !left.has(index))]
    .flat()
    .filter((one): one is number => one !== null && Number.isFinite(one));
  if (!known.length) return null;
  return factor * known.reduce((a, b) => (side === 'above' ? Math.max(a, b) : Math.min(a, b)));
}

/** What a limit lets be at least: `value` the recording reaches, `least` the tightest limit that keeps it; null where all is well. */
export function brokenBy(
  stop: StopDesign,
  curves: readonly PhaseCurve[],
  left: ReadonlySet<number>,
): { value: number; least: number } | null {
  const curve = curves.find((one) => one.channel === stop.channel);
  if (stop.kind !== 'limit' || !curve) return null;
  const side = stop.side ?? 'above';
  const value = farthest(curve, side, left);
  if (value === null) return null;
  const least = value + signOf(side) * ROOM[unitOf(curve)];
  return signOf(side) * ((stop.limit ?? 0) - least) < -1e-6 ? { value, least } : null;
}

/** The extreme of a curve and a margin, outward to whole 5 degrees or centimetres; null for a curve without values. */
export function proposedLimit(curve: PhaseCurve | undefined, side: Side, left: ReadonlySet<number>): number | null {
  const value = curve ? farthest(curve, side, left) : null;
  if (!curve || value === null) return null;
  const unit = unitOf(curve);
  return signOf(side) * Math.ceil((signOf(side) * value + MARGIN[unit]) / STEP[unit] - 1e-9) * STEP[unit];
}
