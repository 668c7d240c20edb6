// Ranges and stretches that charts share.

/** A range that holds the values, in whole steps and not narrower than `least`, so that it seldom moves. */
export function steadyRange(minimum: number, maximum: number, step: number, least: number): [number, number] {
  if (!Number.isFinite(minimum) || !Number.isFinite(maximum)) return [0, least];
  let low = Math.floor(minimum / step) * step;
  let high = Math.ceil(maximum / step) * step;
  while (high - low < least) {
    high += step;
    if (high - low < least) low -= step;
  }
  return [low, high];
}

/** Half-open index ranges in which the test holds. */
export function runs(count: number, test: (index: number) => boolean): [number, number][] {
  const found: [number, number][] = [];
  let start = -1;
  for (let index = 0; index <= count; index += 1) {
    const holds = index < count && test(index);
    if (holds && start < 0) start = index;
    if (!holds && start >= 0) {
      found.push([start, index]);
      start = -1;
    }
  }
  return found;
}

/** Smallest and largest finite value of several arrays; null when there is none. */
export function extent(...arrays: readonly ArrayLike<number | null>[]): [number, number] | null {
  let low = Infinity;
  let high = -Infinity;
  for (const array of arrays) {
    for (let index = 0; index < array.length; index += 1) {
      // The service writes null where it has no number.
      const value = array[index];
      if (typeof value !== 'number') continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  return low <= high ? [low, high] : null;
}

/** Round numbers that span a range, about `count` of them. */
export function niceTicks(low: number, high: number, count: number): number[] {
  const span = high - low;
  if (!(span > 0)) return [low];
  const rough = span / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = ([1, 2, 2.5, 5, 10].find((one) => one * power >= rough) ?? 10) * power;
  const first = Math.floor(low / step + 1e-9);
  const last = Math.ceil(high / step - 1e-9);
  return Array.from({ length: last - first + 1 }, (_, index) => Number(((first + index) * step).toPrecision(12)));
}

/** A named line; null makes a hole in it. */
export interface Line {
  name: string;
  x: readonly (number | null)[];
  y: readonly (number | null)[];
}

/** Lines over one rising axis, as a chart needs them; where a line has no point of its own it has undefined, which is drawn through. */
export function aligned(lines: readonly Line[]): (number | null | undefined)[][] {
  const tables = lines.map(
    (line) => new Map(line.x.flatMap((x, index) => (x === null ? [] : [[x, line.y[index] ?? null] as const]))),
  );
  const axis = [...new Set(tables.flatMap((table) => [...table.keys()]))].sort((a, b) => a - b);
  return [axis, ...tables.map((table) => axis.map((x) => table.get(x)))];
}
