// What a therapist draws on a template while it is being drawn: one band a phase and curve, written as knots when it is saved.
import type { CueDesign, KnotDesign, PhaseCurve, StopDesign, TemplateDesign, WeightDesign } from '../../api/types';

/** How far below and above its curve a phase lets a channel go, times the recorded width; null is free. */
export interface Band {
  below: number | null;
  above: number | null;
}
export type Edge = keyof Band;

/** A stretch that begins where the one before it ends; the last ends at 1. */
export interface PhaseDraft {
  name: string;
  end: number;
}

export interface Draft {
  /** Never empty; one without a name is the whole movement. */
  phases: PhaseDraft[];
  /** One band a phase, of curves that were drawn on. */
  bands: Record<string, Band[]>;
  /** Curves whose knots do not follow the phases, as they came; drawing on one makes it follow them. */
  loose: Record<string, KnotDesign[]>;
  watched: string[];
  stops: StopDesign[];
  cues: CueDesign[];
  validShare: number;
  pace: NonNullable<TemplateDesign['pace']>;
  /** Parts of the weighted sum; empty: there is none. */
  weights: WeightDesign[];
}

export const NARROWEST = 0.2;
export const WIDEST = 20;
export const SHORTEST = 0.04;
export const MOST_PHASES = 12;
const RAMP = 0.02;
const RECORDED: Band = { below: 1, above: 1 };

/** The factor of knots at a phase, as the service reads them: straight lines, and next to a free knot free. */
export function factorAt(knots: readonly KnotDesign[], edge: Edge, phase: number): number | null {
  const first = knots[0];
  const last = knots.at(-1);
  if (!first || !last) return 1;
  const value = (knot: KnotDesign) => (knot[edge] === undefined ? 1 : knot[edge]);
  if (phase <= first.phase) return value(first);
  if (phase >= last.phase) return value(last);
  const index = knots.findIndex((knot) => knot.phase >= phase);
  const after = knots[index] ?? last;
  const before = knots[index - 1] ?? first;
  const [low, high] = [value(before), value(after)];
  if (after.phase === phase) return high;
  if (low === null || high === null) return null;
  return low + ((high - low) * (phase - before.phase)) / (after.phase - before.phase);
}

/** Where each phase begins and ends. */
export function stretches(phases: readonly PhaseDraft[]): [number, number][] {
  return phases.map((one, index) => [phases[index - 1]?.end ?? 0, one.end]);
}

/** Knots of one band a phase: level inside, with a short slope at each border. */
export function knotsOf(phases: readonly PhaseDraft[], bands: readonly Band[]): KnotDesign[] {
  return stretches(phases).flatMap(([start, end], index) => {
    const band = bands[index] ?? RECORDED;
    const ramp = Math.min(RAMP, (end - start) / 4);
    const at = [start === 0 ? 0 : start + ramp, end === 1 ? 1 : end - ramp];
    return at.map((phase) => ({ phase: Number(phase.toFixed(4)), ...band }));
  });
}

/** The knots that a draft gives a curve. */
export function knotsFor(draft: Draft, channel: string): KnotDesign[] {
  const bands = draft.bands[channel];
  return bands ? knotsOf(draft.phases, bands) : (draft.loose[channel] ?? [{ phase: 0, ...RECORDED }]);
}

/** The bands of a curve by phase, whether or not it was drawn on. */
export function bandsFor(draft: Draft, channel: string): Band[] {
  const knots = knotsFor(draft, channel);
  return (
    draft.bands[channel] ??
    stretches(draft.phases).map(([start, end]) => ({
      below: factorAt(knots, 'below', (start + end) / 2),
      above: factorAt(knots, 'above', (start + end) / 2),
    }))
  );
}

/** Both edges of a curve's band over 101 phases in the units of the curve; null where free or not measured. */
export function edgesOf(
  curve: PhaseCurve,
  knots: readonly KnotDesign[],
): { low: (number | null)[]; high: (number | null)[] } {
  const edge = (name: Edge, sign: number) =>
    curve.mean.map((mean, index) => {
      const width = curve.width?.[index];
      const factor = factorAt(knots, name, index / 100);
      return mean === null || width === null || width === undefined || factor === null
        ? null
        : mean + sign * factor * width;
    });
  return { low: edge('below', -1), high: edge('above', 1) };
}

/** A stored design as a draft; phases are closed up to one another, from the beginning to the end. */
export function draftOf(design: TemplateDesign): Draft {
  const stored = design.phases ?? [];
  const phases: PhaseDraft[] = stored.length
    ? stored.map((one, index) => ({ name: one.name, end: stored[index + 1]?.start ?? 1 }))
    : [{ name: '', end: 1 }];
  const bands: Draft['bands'] = {};
  const loose: Draft['loose'] = {};
  for (const one of design.tolerances ?? []) {
    const own = stretches(phases).map(([start, end]) => ({
      below: factorAt(one.knots, 'below', (start + end) / 2),
      above: factorAt(one.knots, 'above', (start + end) / 2),
    }));
    if (isSame(knotsOf(phases, own), one.knots)) bands[one.channel] = own;
    else loose[one.channel] = one.knots;
  }
  return {
    phases,
    bands,
    loose,
    watched: design.watched ?? [],
    stops: design.stops ?? [],
    cues: design.cues ?? [],
    validShare: design.valid_share ?? 0.8,
    pace: design.pace ?? {},
    weights: design.weights ?? [],
  };
}

function isSame(one: readonly KnotDesign[], other: readonly KnotDesign[]): boolean {
  return (
    one.length === other.length &&
    one.every((knot, index) => {
      const twin = other[index];
      return twin && Math.abs(twin.phase - knot.phase) < 1e-3 && twin.below === knot.below && twin.above === knot.above;
    })
  );
}

/** What is sent; curves whose band is as recorded are left out. */
export function designOf(draft: Draft): TemplateDesign {
  const named = draft.phases.length > 1 || draft.phases[0]?.name.trim();
  const isDrawn = (bands: readonly Band[]) => bands.some((band) => band.below !== 1 || band.above !== 1);
  return {
    phases: named
      ? stretches(draft.phases).map(([start, end], index) => ({
          name: draft.phases[index]?.name.trim() ?? '',
          start,
          end,
        }))
      : [],
    tolerances: [
      ...Object.entries(draft.bands)
        .filter(([, bands]) => isDrawn(bands))
        .map(([channel, bands]) => ({ channel, knots: knotsOf(draft.phases, bands) })),
      ...Object.entries(draft.loose).map(([channel, knots]) => ({ channel, knots })),
    ],
    watched: draft.watched,
    stops: draft.stops,
    cues: draft.cues,
    valid_share: draft.validShare,
    pace: draft.pace,
    weights: draft.weights.filter((one) => one.weight !== 0),
  };
}

/** One edge of one phase of a curve set anew. */
export function withBand(draft: Draft, channel: string, phase: number, edge: Edge, factor: number | null): Draft {
  const limited = factor === null ? null : Number(Math.min(WIDEST, Math.max(NARROWEST, factor)).toFixed(3));
  const bands = bandsFor(draft, channel).map((band, index) => (index === phase ? { ...band, [edge]: limited } : band));
  const loose = Object.fromEntries(Object.entries(draft.loose).filter(([name]) => name !== channel));
  return { ...draft, bands: { ...draft.bands, [channel]: bands }, loose };
}

/** The border after a phase moved; it stops before its neighbours. */
export function withBorder(draft: Draft, phase: number, end: number): Draft {
  const [start] = stretches(draft.phases)[phase] ?? [0];
  const next = draft.phases[phase + 1]?.end;
  if (next === undefined) return draft;
  const border = Number(Math.min(next - SHORTEST, Math.max(start + SHORTEST, end)).toFixed(3));
  return { ...draft, phases: draft.phases.map((one, index) => (index === phase ? { ...one, end: border } : one)) };
}

/** A phase cut in two halves; both have its band. */
export function withSplit(draft: Draft, phase: number, name: string): Draft {
  const [start, end] = stretches(draft.phases)[phase] ?? [0, 0];
  if (end - start < 2 * SHORTEST || draft.phases.length >= MOST_PHASES) return draft;
  const middle = Number(((start + end) / 2).toFixed(3));
  const phases = draft.phases.flatMap((one, index) =>
    index === phase
      ? [
          { ...one, end: middle },
          { name, end },
        ]
      : [one],
  );
  return withPhases(draft, phases, (index) => (index <= phase ? index : index - 1));
}

/** A phase taken away; its neighbour takes its place. */
export function withoutPhase(draft: Draft, phase: number): Draft {
  if (draft.phases.length === 1) return { ...draft, phases: [{ name: '', end: 1 }] };
  const phases = draft.phases.filter((_, index) => index !== phase);
  const last = phases.at(-1);
  if (last) phases[phases.length - 1] = { ...last, end: 1 };
  return withPhases(draft, phases, (index) => (index < phase ? index : index + 1));
}

/** Phases replaced; `before` says from which earlier phase each takes its bands. */
export function withPhases(draft: Draft, phases: PhaseDraft[], before: (index: number) => number): Draft {
  const bands = Object.fromEntries(
    Object.entries(draft.bands).map(([channel, own]) => [
      channel,
      phases.map((_, index) => own[Math.min(own.length - 1, Math.max(0, before(index)))] ?? RECORDED),
    ]),
  );
  return { ...draft, phases, bands };
}

const NEAR_TOP = 0.9;
const LONG_HOLD = 0.15;

/** Phases as the main curve suggests them: to its farthest point and back, with a hold where it stays there. */
export function suggestedBorders(mean: readonly (number | null)[]): number[] {
  const first = mean.find((value) => value !== null) ?? 0;
  const away = mean.map((value) => Math.abs((value ?? first) - first));
  const top = Math.max(...away);
  if (!(top > 0)) return [];
  const near = away.map((value, index) => [value, index] as const).filter(([value]) => value >= NEAR_TOP * top);
  const start = (near[0]?.[1] ?? 0) / 100;
  const end = (near.at(-1)?.[1] ?? 100) / 100;
  const limit = (at: number) => Math.min(1 - SHORTEST, Math.max(SHORTEST, at));
  if (end - start < LONG_HOLD) return [limit(away.indexOf(top) / 100)];
  return [limit(start), limit(end)];
}
