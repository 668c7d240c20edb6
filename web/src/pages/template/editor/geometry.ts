// Where things of a curve lie in the picture, and what a place in the picture means for the band.
import type { PhaseCurve } from '../../../api/types';
import { bandsFor, NARROWEST, stretches, WIDEST, type Draft, type Edge } from '../../../lib/assessment/design';
import { extent } from '../../../charts/scales';

export const PAD = { left: 58, right: 22, top: 34, bottom: 58 };
const ROOM = 2.2;

/** Lowest and highest value of the picture of a curve; they do not move while a band is drawn. */
export function domainOf(curve: PhaseCurve, limits: readonly number[] = []): [number, number] {
  const [low, high] = extent(curve.mean, ...curve.repetitions) ?? [0, 1];
  const room = ROOM * Math.max(...(curve.width ?? []).map((one) => one ?? 0), (high - low) / 20, 1e-6);
  // A limit is in the picture, with room for its word.
  const edge = (high - low + 2 * room) / 12;
  return [
    Math.min(low - room, ...limits.map((one) => one - edge)),
    Math.max(high + room, ...limits.map((one) => one + edge)),
  ];
}

/** One edge of the band in the middle of a phase, where its handle sits. */
export interface Handle {
  phase: number;
  edge: Edge;
  /** Index of the phase, 0 to 100, at which it sits. */
  at: number;
  mean: number;
  width: number;
  factor: number | null;
  /** Null where free. */
  value: number | null;
}

const SIGN = { below: -1, above: 1 };

/** The handles of a curve, in the order of their phases; none for a phase in which nothing was measured. */
export function handlesOf(curve: PhaseCurve, draft: Draft): Handle[] {
  const bands = bandsFor(draft, curve.channel);
  return stretches(draft.phases).flatMap(([start, end], phase) => {
    const middle = Math.round(50 * (start + end));
    const measured = Array.from({ length: 101 }, (_, index) => index)
      .filter(
        (index) => index >= 100 * start && index <= 100 * end && curve.mean[index] !== null && curve.width?.[index],
      )
      .sort((a, b) => Math.abs(a - middle) - Math.abs(b - middle));
    const at = measured[0];
    if (at === undefined) return [];
    const mean = curve.mean[at] ?? 0;
    const width = curve.width?.[at] ?? 1;
    return (['above', 'below'] as const).map((edge) => {
      const factor = bands[phase]?.[edge] ?? null;
      return {
        phase,
        edge,
        at,
        mean,
        width,
        factor,
        value: factor === null ? null : mean + SIGN[edge] * factor * width,
      };
    });
  });
}

/** The factor that puts a handle at a value of the curve. */
export function factorFor(handle: Handle, value: number): number {
  return Math.min(WIDEST, Math.max(NARROWEST, (SIGN[handle.edge] * (value - handle.mean)) / handle.width));
}

/** How far an arrow key moves a handle: a degree, or half a centimetre. */
export function stepOf(curve: PhaseCurve): number {
  return curve.unit === 'm' ? 0.005 : 1;
}
