// A walk as its page shows it: measures in words and units, rows of the tables, the frame of the map.
import type { Gait, GaitFoot, MeasureChange, Stride, WalkMeasure } from '../../api/types';
import measures from '../../api/measures.json';
import { tOr } from '../../i18n';
import { number, pair, quantity, uncertain } from '../../lib/format';

/** Seen first; all others when asked for. */
export const MAIN_MEASURES: readonly string[] = measures.foot.main;

/** A measure in plain words. */
export function measureLabel(name: string): string {
  const words = name.replaceAll('_', ' ');
  return tOr(`measure.${name}`, words.charAt(0).toUpperCase() + words.slice(1));
}

/** Units that a walk shows in a way of its own: digits and sign. */
const FINER: Partial<Record<string, readonly [number, string]>> = { 'steps/min': [0, ' /min'], s: [2, ' s'] };

/** Parts of one are shown in per cent, everything else in its usual unit. */
export function measureText(value: number | null | undefined, unit: string, sigma: number | null = null): string {
  if (value === null || value === undefined) return '–';
  if (unit === '1') return uncertain(value * 100, sigma === null ? null : sigma * 100, '%');
  const [digits, suffix] = FINER[unit] ?? [];
  if (digits === undefined) return uncertain(value, sigma, unit);
  if (sigma === null) return `${number(value, digits)}${suffix}`;
  const [text, size] = pair(value, sigma, digits);
  return `${text}${suffix} ± ${size}`;
}

/** The foot of a side, when it was worn. */
export function footOf(gait: Gait, side: 'left' | 'right'): GaitFoot | undefined {
  return gait.feet.find((one) => one.side === side);
}

/** `StrideFlag.OUTSIDE`: before Record was pressed or after Stop. */
const OUTSIDE = 16;

export const isOutside = (stride: Stride | undefined): boolean => ((stride?.flags ?? 0) & OUTSIDE) !== 0;

/** Whether a place where a foot stood is only of strides before Record or after Stop. */
export function isOutsideHold(foot: GaitFoot, index: number): boolean {
  const beside = [foot.strides[index - 1], foot.strides[index]].filter((one) => one !== undefined);
  return beside.length > 0 && beside.every(isOutside);
}

/** Strides of both feet in the whole walk. */
export const strideCount = (gait: Gait): number =>
  gait.feet.reduce((sum, foot) => sum + (foot.stride_count || foot.strides.length), 0);

/** Whether the answer has all strides; a walk of hours comes with its first ones. */
export const isWhole = (gait: Gait): boolean =>
  gait.feet.every((foot) => (foot.stride_count ?? 0) <= foot.strides.length);

export function findMeasure(measures: readonly WalkMeasure[] | undefined, name: string): WalkMeasure | undefined {
  return measures?.find((one) => one.measure === name);
}

/** Names of all measures of the feet, the main ones first. */
export function measureNames(gait: Gait, all: boolean): string[] {
  const known = [...new Set(gait.feet.flatMap((foot) => foot.measures.map((one) => one.measure)))];
  const main = MAIN_MEASURES.filter((name) => known.includes(name));
  return all ? [...main, ...known.filter((name) => !main.includes(name))] : main;
}

const PARTS = ['feet', 'both', 'asymmetry', 'balance'] as const;
type Part = (typeof PARTS)[number];
const OF_BOTH: readonly string[] = [...measures.both.main, ...measures.both.more];

/** What a comparison of conditions has, in the parts of its table; left and right of a measure beside each other. */
export function partsOf(changes: readonly MeasureChange[]): [Part, MeasureChange[]][] {
  const partOf = (one: MeasureChange): Part =>
    one.foot !== 'both'
      ? 'feet'
      : one.measure.endsWith('_asymmetry')
        ? 'asymmetry'
        : OF_BOTH.includes(one.measure)
          ? 'both'
          : 'balance';
  const names = [...new Set(changes.map((one) => one.measure))];
  const inOrder = [...changes].sort((one, other) => names.indexOf(one.measure) - names.indexOf(other.measure));
  return PARTS.map((part): [Part, MeasureChange[]] => [part, inOrder.filter((one) => partOf(one) === part)]).filter(
    ([, found]) => found.length > 0,
  );
}

export interface MapFrame {
  minX: number;
  maxX: number;
  minY: number;
  maxY: number;
  /** Pixels for a metre. */
  scale: number;
  /** Whether the walk goes up instead of to the right, as on a telephone. */
  isUpright: boolean;
}

const AROUND_M = 0.3;
/** Narrower than this the walk is drawn upward. */
const UPRIGHT_BELOW = 560;
/** So high at most, as long as the feet stay feet. */
const UPRIGHT_HEIGHT = 900;

/** The part of the floor that the map shows: all footprints and paths, at a scale that fits a page. */
export function mapFrame(gait: Gait, width: number): MapFrame {
  const xs: number[] = [];
  const ys: number[] = [];
  for (const foot of gait.feet) {
    for (const hold of foot.footholds) {
      xs.push(hold.x_m);
      ys.push(hold.y_m);
    }
  }
  for (const [x, y] of gait.balance?.centre_m ?? []) {
    xs.push(x ?? 0);
    ys.push(y ?? 0);
  }
  const isUpright = width < UPRIGHT_BELOW;
  if (xs.length === 0)
    return { minX: -AROUND_M, maxX: AROUND_M, minY: -AROUND_M, maxY: AROUND_M, scale: 100, isUpright };
  const minX = Math.min(...xs) - AROUND_M;
  const maxX = Math.max(...xs) + AROUND_M;
  const minY = Math.min(...ys) - AROUND_M;
  const maxY = Math.max(...ys) + AROUND_M;
  const scale = isUpright
    ? Math.max(60, Math.min(150, UPRIGHT_HEIGHT / (maxX - minX), width / (maxY - minY)))
    : Math.min(240, Math.max(110, width / (maxX - minX)));
  return { minX, maxX, minY, maxY, scale, isUpright };
}

/** A path on the floor for SVG. */
export function floorPath(points: readonly (readonly number[])[], frame: MapFrame): string {
  return points
    .map(
      ([x = 0, y = 0], index) =>
        `${index === 0 ? 'M' : 'L'}${((x - frame.minX) * frame.scale).toFixed(1)} ${((frame.maxY - y) * frame.scale).toFixed(1)}`,
    )
    .join('');
}

/** Where the centre of mass is carried, in words that a person would use. */
export function leaning(
  measures: readonly WalkMeasure[],
  name: 'centre_to_left' | 'centre_to_left_standing',
): { side: 'left' | 'right' | 'middle'; distance: string } | null {
  const found = findMeasure(measures, name);
  if (!found || found.value === null) return null;
  const { value } = found;
  const side = Math.abs(value) < Math.max(0.005, found.sigma ?? 0) ? 'middle' : value > 0 ? 'left' : 'right';
  return { side, distance: quantity(Math.abs(value), 'm') };
}
