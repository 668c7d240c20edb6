// The newest frames of a live session in fixed memory: the oldest give way, nothing grows.
import type { Block } from './block';
import type { Columns, Stretch } from './types';

const EMPTY = new Float32Array(0);

export class FrameRing {
  readonly #capacity: number;
  readonly #time: Float64Array;
  readonly #values: Float32Array[];
  #columns: Columns;
  #start = 0;
  #count = 0;

  /** Room for `seconds` of frames with these columns. */
  constructor(columns: Columns, seconds: number) {
    this.#columns = columns;
    this.#capacity = Math.max(1, Math.ceil(columns.rateHz * seconds));
    this.#time = new Float64Array(this.#capacity);
    this.#values = columns.names.map(() => new Float32Array(this.#capacity));
  }

  get count(): number {
    return this.#count;
  }

  /** Time of the newest frame, NaN while there is none. */
  get lastS(): number {
    return this.#count ? this.#timeAt(this.#count - 1) : NaN;
  }

  /** Time of the oldest frame held, NaN while there is none. */
  get firstS(): number {
    return this.#count ? this.#timeAt(0) : NaN;
  }

  clear(): void {
    this.#start = 0;
    this.#count = 0;
  }

  /** Append a block. Ticks that are not later than the newest held are left out: time never runs back. */
  push(block: Block): void {
    const last = this.#count ? this.lastS : -Infinity;
    for (let tick = 0; tick < block.ticks; tick += 1) {
      const timeS = block.startS + tick * block.stepS;
      if (timeS <= last + block.stepS / 2) continue;
      const place = (this.#start + this.#count) % this.#capacity;
      this.#time[place] = timeS;
      this.#values.forEach((values, column) => {
        values[place] = block.columns[column]?.[tick] ?? NaN;
      });
      if (this.#count < this.#capacity) this.#count += 1;
      else this.#start = (this.#start + 1) % this.#capacity;
    }
  }

  /** Frames of the half-open interval. A step longer than 1.5 ticks is shown as a break. */
  read(startS: number, endS: number, names: readonly string[]): Stretch {
    const from = this.#lowerBound(startS);
    const until = this.#lowerBound(endS);
    const breakS = 1.5 / this.#columns.rateHz;
    const breaks: number[] = [];
    for (let index = from + 1; index < until; index += 1) {
      if (this.#timeAt(index) - this.#timeAt(index - 1) > breakS) breaks.push(index);
    }
    const size = Math.max(0, until - from) + breaks.length;
    const timeS = new Float64Array(size);
    const values = names.map((name) => (this.#columns.index.has(name) ? new Float32Array(size) : EMPTY));
    const sources = names.map((name) => this.#values[this.#columns.index.get(name) ?? -1]);
    let nextBreak = 0;
    let out = 0;
    for (let index = from; index < until; index += 1) {
      if (breaks[nextBreak] === index) {
        timeS[out] = (this.#timeAt(index - 1) + this.#timeAt(index)) / 2;
        for (const array of values) array[out] = NaN;
        nextBreak += 1;
        out += 1;
      }
      timeS[out] = this.#timeAt(index);
      const place = (this.#start + index) % this.#capacity;
      values.forEach((array, column) => {
        array[out] = sources[column]?.[place] ?? NaN;
      });
      out += 1;
    }
    return { timeS, values, isComplete: true };
  }

  #timeAt(index: number): number {
    return this.#time[(this.#start + index) % this.#capacity] ?? NaN;
  }

  #lowerBound(timeS: number): number {
    let low = 0;
    let high = this.#count;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.#timeAt(middle) < timeS) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}
