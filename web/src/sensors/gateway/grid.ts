// Samples as they come, each sensor in its own time, to the common even ticks that a packet holds.
import { MOTION_VALUES } from './packet';

/** A longer silence of a sensor is a gap: zeros, which the service takes for nothing measured. */
export const LONGEST_LINE_MS = 200;
/** How long the ticks of all sensors wait for one that is late, unless it is known to be gone: radio brings some late. */
const WAIT_MS = 1000;
/** After so long without a sample of any sensor, ticks begin anew and no zeros are written for the time between. */
export const LONGEST_HOLE_MS = 2000;

/** Gyroscope x, y, z in rad/s, then accelerometer x, y, z in m/s² (what it feels: +9.8 on the axis that points up). */
export type Sample = readonly [number, number, number, number, number, number];

export interface Tick {
  /** Number on the grid; times of ticks are number times the interval. */
  number: number;
  /** All sensors, six values each. */
  values: Float32Array;
}

/** One sensor's way onto the grid. */
class Row {
  #timeMs = Number.NaN;
  #sample: Sample | null = null;
  /** Values by tick, not yet given. */
  readonly ready = new Map<number, Sample>();
  /** Others wait for it. */
  isAwaited = true;

  get timeMs(): number {
    return this.#timeMs;
  }

  /** Take a sample; ticks between it and the one before lie on a line. */
  add(timeMs: number, sample: Sample, stepMs: number): void {
    const before = this.#sample;
    const beforeMs = this.#timeMs;
    // Two samples of one moment, or a clock that stepped back: the first counts.
    if (before && timeMs <= beforeMs) return;
    this.#timeMs = timeMs;
    this.#sample = sample;
    this.isAwaited = true;
    if (!before || timeMs - beforeMs > LONGEST_LINE_MS) {
      // A tick falls onto this sample itself only by chance; the next sample fills what follows.
      const here = Math.round(timeMs / stepMs);
      if (Math.abs(here * stepMs - timeMs) < 0.01 * stepMs) this.ready.set(here, sample);
      return;
    }
    for (let tick = Math.floor(beforeMs / stepMs) + 1; tick * stepMs <= timeMs; tick += 1) {
      const share = (tick * stepMs - beforeMs) / (timeMs - beforeMs);
      this.ready.set(
        tick,
        sample.map((value, at) => (before[at] ?? 0) * (1 - share) + value * share) as unknown as Sample,
      );
    }
  }

  forget(): void {
    this.ready.clear();
    this.#sample = null;
    this.#timeMs = Number.NaN;
  }
}

/** Puts the samples of several sensors onto even ticks. Times are milliseconds of one clock. */
export class Grid {
  readonly stepMs: number;
  readonly #rows: Row[];
  #next = Number.NaN;
  #newestMs = -Infinity;
  #hasBegun = false;

  constructor(sensors: number, rateHz: number) {
    this.stepMs = 1000 / rateHz;
    this.#rows = Array.from({ length: sensors }, () => new Row());
  }

  /** Take a sample and give the ticks that are complete with it. */
  add(sensor: number, timeMs: number, sample: Sample): Tick[] {
    const row = this.#rows[sensor];
    if (!row || !Number.isFinite(timeMs)) return [];
    const done: Tick[] = [];
    if (timeMs - this.#newestMs > LONGEST_HOLE_MS) {
      done.push(...this.rest());
      for (const one of this.#rows) one.forget();
      this.#hasBegun = false;
      this.#next = Math.ceil(timeMs / this.stepMs - 0.01);
    }
    this.#newestMs = Math.max(this.#newestMs, timeMs);
    row.add(timeMs, sample, this.stepMs);
    done.push(...this.#complete());
    return done;
  }

  /** A sensor is gone: the others no longer wait for it, until it gives something again. */
  leave(sensor: number): void {
    const row = this.#rows[sensor];
    if (row) row.isAwaited = false;
  }

  /** What is there and waits for a late sensor, before a pause. */
  rest(): Tick[] {
    const last = Math.max(...this.#rows.flatMap((row) => [...row.ready.keys()]), -Infinity);
    return Number.isFinite(last) ? this.#until(last) : [];
  }

  #complete(): Tick[] {
    const awaited = this.#rows.filter((row) => row.isAwaited);
    const slowest = Math.min(...awaited.map((row) => (Number.isNaN(row.timeMs) ? -Infinity : row.timeMs)));
    const untilMs = Math.max(Math.min(slowest, this.#newestMs), this.#newestMs - WAIT_MS);
    return this.#until(Math.floor(untilMs / this.stepMs + 1e-9));
  }

  #until(last: number): Tick[] {
    const done: Tick[] = [];
    for (; this.#next <= last; this.#next += 1) {
      const values = new Float32Array(this.#rows.length * MOTION_VALUES);
      let isEmpty = true;
      this.#rows.forEach((row, sensor) => {
        const sample = row.ready.get(this.#next);
        if (!sample) return;
        isEmpty = false;
        values.set(sample, sensor * MOTION_VALUES);
        row.ready.delete(this.#next);
      });
      // Before the very first values there is nothing to say; later an empty tick says that nothing was measured.
      this.#hasBegun ||= !isEmpty;
      if (this.#hasBegun) done.push({ number: this.#next, values });
    }
    for (const row of this.#rows) {
      for (const tick of row.ready.keys()) if (tick < this.#next) row.ready.delete(tick);
    }
    return done;
  }
}
