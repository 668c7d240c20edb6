// Lean and sway in live frames, and measures with their uncertainty in the units of a clinic.
import type { Named } from '../../api/types';
import { number, pair } from '../../lib/format';
import type { Player } from '../../player/types';

const GRAVITY = 9.80665;
const OVER_S = 10;
/** Samples that are averaged against sensor noise, as a share of a second. */
const SMOOTH_S = 0.2;

export interface LeanNow {
  forward: number[];
  left: number[];
  /** Horizontal acceleration freed of gravity. */
  pushedForward: number[];
  pushedLeft: number[];
  /** Samples in a smoothing window. */
  window: number;
}

/** The last ten seconds of a sensor; null before the first frame with numbers. */
export function readLean(player: Player, place: string): LeanNow | null {
  const { timeS } = player.clock();
  const names = ['lean_forward_rad', 'lean_left_rad', 'acceleration_forward_mps2', 'acceleration_left_mps2'];
  const read = player.read(
    timeS - OVER_S,
    timeS + 1e-6,
    names.map((name) => `${place}_${name}`),
  );
  const sound = [...read.timeS.keys()].filter((index) => read.values.every((one) => Number.isFinite(one[index])));
  if (sound.length < 2 || read.values.length < names.length) return null;
  const column = (index: number) => sound.map((at) => read.values[index]?.[at] ?? NaN);
  const first = read.timeS[sound[0] ?? 0] ?? 0;
  const last = read.timeS[sound.at(-1) ?? 0] ?? 0;
  const stepS = (last - first) / (sound.length - 1);
  return {
    forward: column(0),
    left: column(1),
    pushedForward: column(2),
    pushedLeft: column(3),
    window: Math.max(1, Math.round(SMOOTH_S / stepS)),
  };
}

/** Sway acceleration, axes levelled by the mean lean: forward and left, as the service computes it off-line. */
export function levelled(now: LeanNow): [number[], number[]] {
  const side = (lean: readonly number[], pushed: readonly number[]) => {
    const middle = mean(lean);
    return smooth(
      pushed.map((one, index) => one - GRAVITY * Math.sin((lean[index] ?? 0) - middle)),
      now.window,
    );
  };
  return [side(now.forward, now.pushedForward), side(now.left, now.pushedLeft)];
}

/** Of both directions together, each about its mean. */
export function rootMeanSquare(sides: readonly (readonly number[])[]): number {
  const variance = (values: readonly number[]) => {
    const middle = mean(values);
    return mean(values.map((one) => (one - middle) ** 2));
  };
  return Math.sqrt(sides.reduce((sum, one) => sum + variance(one), 0));
}

const mean = (values: readonly number[]) => values.reduce((sum, one) => sum + one, 0) / values.length;

function smooth(values: readonly number[], window: number): number[] {
  return values.slice(window - 1).map((_, index) => mean(values.slice(index, index + window)));
}

/** How a unit of the service is written: factor, name, digits. */
const UNITS: Record<string, [number, string, number]> = {
  'm^2': [1e4, 'cm²', 1],
  'm/s': [1e3, 'mm/s', 1],
  m: [1e3, 'mm', 1],
  'm/s^2': [1, 'm/s²', 3],
  'm/s^3': [1, 'm/s³', 2],
  Hz: [1, 'Hz', 2],
  rad: [180 / Math.PI, '°', 1],
  '1': [1, '', 2],
};

/** A measure with its uncertainty; lengths of more than 10 cm in centimetres. */
export function measureText(one: Named<'BalanceMeasure'> | undefined): string {
  if (!one || one.value === null) return '–';
  const isLong = one.unit === 'm' && Math.abs(one.value) >= 0.1;
  const [factor, name, digits] = isLong ? ([100, 'cm', 1] as const) : (UNITS[one.unit] ?? [1, one.unit, 2]);
  const value = one.value * factor;
  const text = one.sigma === null ? number(value, digits) : pair(value, one.sigma * factor, digits).join(' ± ');
  return `${text}${name === '°' || !name ? name : ` ${name}`}`;
}
