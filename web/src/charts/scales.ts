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
