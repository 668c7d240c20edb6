// What measures and where its samples go: the phone itself, or sensors that are worn.
import type { Sample } from './gateway/grid';

/** Why a source cannot measure; each has its sentence, `sensors.fault.*`. */
export type FaultCode =
  | 'unsupported'
  | 'insecure'
  | 'denied'
  | 'silent'
  | 'noGyroscope'
  | 'noAccelerometer'
  | 'tooSlow'
  | 'notChosen'
  | 'notOurs'
  | 'radioOff'
  | 'cut'
  | 'otherWindow'
  | 'failed';

export class SensorFault extends Error {
  override readonly name = 'SensorFault';
  constructor(readonly code: FaultCode) {
    super(code);
  }
}

/** Takes a sample of a sensor; `timeMs` as events are stamped, milliseconds since the page was opened. */
export type OnSample = (timeMs: number, sample: Sample) => void;

export const RAD_PER_DEG = Math.PI / 180;

/** Slower than this no movement can be followed. */
const SLOWEST_HZ = 20;
/** What packets are declared as: the rates that sensors have. */
const RATES_HZ = [60, 50, 30, 20] as const;

/**
 * The rate to declare for samples that came at these times: the nearest usual one that is not above what came, so that
 * lines are drawn between real samples and nothing is invented.
 */
export function rateOf(timesMs: readonly number[]): number {
  const intervals = timesMs
    .slice(1)
    .map((ms, at) => ms - (timesMs[at] ?? 0))
    .sort((a, b) => a - b);
  const median = intervals[Math.floor(intervals.length / 2)];
  if (!median || median <= 0) throw new SensorFault('tooSlow');
  const found = RATES_HZ.find((rate) => 1000 / median > 0.9 * rate);
  if (!found || 1000 / median < 0.9 * SLOWEST_HZ) throw new SensorFault('tooSlow');
  return found;
}
