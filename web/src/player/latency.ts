// From publication by the service to arrival here, with two clocks that may disagree.

const SHOWN = 60;

/**
 * Median of the newest delays. Where this machine's clock stands behind the service's (a negative delay, which cannot be),
 * delays are stated relative to the shortest one seen, which is then the least that can be said.
 */
export class LatencyMeter {
  readonly now: () => number;
  readonly #delays: number[] = [];
  #shortestMs = Infinity;

  constructor(now: () => number = () => Date.now() / 1000) {
    this.now = now;
  }

  add(arrivedAtS: number, publishedS: number): void {
    const delayMs = (arrivedAtS - publishedS) * 1000;
    if (!Number.isFinite(delayMs)) return;
    this.#shortestMs = Math.min(this.#shortestMs, delayMs);
    this.#delays.push(delayMs);
    if (this.#delays.length > SHOWN) this.#delays.shift();
  }

  /** Median in ms, null before the first frame. */
  read(): number | null {
    if (this.#delays.length === 0) return null;
    const sorted = [...this.#delays].sort((a, b) => a - b);
    const median = sorted[sorted.length >> 1] ?? 0;
    return median - Math.min(0, this.#shortestMs);
  }
}
