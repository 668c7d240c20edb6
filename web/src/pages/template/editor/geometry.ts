// Where things of a curve lie in the picture, and what a place in the picture means for the band.
import type { PhaseCurve } from '../../../api/types';
import { bandsFor, NARROWEST, stretches, WIDEST, type Draft, type Edge } from '../../../lib/assessment/design';
import { extent, niceTicks } from '../../../charts/scales';

export const PAD = { left: 58, right: 22, top: 34, bottom: 58 };
const ROOM = 2.2;

/** Scales of one curve in a picture of this size; they do not move while a band is drawn. */
export interface Scales {
  x: (phase: number) => number;
  y: (value: number) => number;
  phaseAt: (x: number) => number;
  valueAt: (y: number) => number;
  top: number;
  bottom: number;
  ticks: number[];
}

export function scalesOf(curve: PhaseCurve, width: number, height: number, limits: readonly number[] = []): Scales {
  const [low, high] = extent(curve.mean, ...curve.repetitions) ?? [0, 1];
  const room = ROOM * Math.max(...(curve.width ?? []).map((one) => one ?? 0), (high - low) / 20, 1e-6);
  // A limit is in the picture, with room for its word.
  const edge = (high - low + 2 * room) / 12;
  const from = Math.min(low - room, ...limits.map((one) => one - edge));
  const to = Math.max(high + room, ...limits.map((one) => one + edge));
  const top = PAD.top;
  const bottom = height - PAD.bottom;
  const across = Math.max(1, width - PAD.left - PAD.right);
  return {
    x: (phase) => PAD.left + phase * across,
    y: (value) => bottom - ((value - from) / (to - from)) * (bottom - top),
    phaseAt: (x) => (x - PAD.left) / across,
    valueAt: (y) => from + ((bottom - y) / (bottom - top)) * (to - from),
    top,
    bottom,
    ticks: niceTicks(from, to, Math.max(2, Math.round((bottom - top) / 56))).filter((one) => one >= from && one <= to),
  };
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

/** A line through what is known, with holes where it is not. */
export function lineOf(values: readonly (number | null)[], scales: Scales): string {
  let isDown = false;
  return values
    .map((value, index) => {
      if (value === null || !Number.isFinite(value)) {
        isDown = false;
        return '';
      }
      const command = `${isDown ? 'L' : 'M'}${scales.x(index / 100).toFixed(1)} ${scales.y(value).toFixed(1)}`;
      isDown = true;
      return command;
    })
    .join('');
}

/** The area of the band; where an edge is free it reaches to the rim of the picture. */
export function areaOf(
  curve: PhaseCurve,
  edges: { low: readonly (number | null)[]; high: readonly (number | null)[] },
  scales: Scales,
): string {
  const parts: string[] = [];
  let start = -1;
  for (let index = 0; index <= 101; index += 1) {
    const isKnown = index <= 100 && curve.mean[index] !== null && curve.mean[index] !== undefined;
    if (isKnown && start < 0) start = index;
    if (!isKnown && start >= 0) {
      const inside = Array.from({ length: index - start }, (_, step) => start + step);
      const at = (value: number | null | undefined, rim: number) =>
        value === null || value === undefined ? rim : Math.min(scales.bottom, Math.max(scales.top, scales.y(value)));
      const upper = inside.map((i) => `${scales.x(i / 100).toFixed(1)} ${at(edges.high[i], scales.top).toFixed(1)}`);
      const lower = inside
        .reverse()
        .map((i) => `${scales.x(i / 100).toFixed(1)} ${at(edges.low[i], scales.bottom).toFixed(1)}`);
      parts.push(`M${[...upper, ...lower].join('L')}Z`);
      start = -1;
    }
  }
  return parts.join('');
}
