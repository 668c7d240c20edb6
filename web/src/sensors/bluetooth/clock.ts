// A sensor's clock on the page's clock, from when its messages arrive: radio only ever delays.

const BLOCK_US = 3e6;
const BLOCKS = 10;
/** No quartz of a sensor is worse. */
const MOST_SKEW = 1e-4;
/** A better estimate is taken up slowly, so that time never jumps: so much a message. */
const SLEW_MS = 0.1;
/** One that is far off is left sooner: two sensors would be apart meanwhile. */
const FAR_MS = 5;
const FAR_SLEW_MS = 2;
/** A block whose quickest message was slower by more than this tells nothing: the page stood still. */
const STALLED_MS = 15;

interface Block {
  startUs: number;
  deviceUs: number;
  /** Least delay in it: arrival less device time, milliseconds. */
  leastMs: number;
}

/** Unwraps a counter of 32 bits. */
export class Unwrapped {
  #last = 0;
  #turns = 0;

  of(raw: number): number {
    if (raw < this.#last - 2 ** 31) this.#turns += 1;
    this.#last = raw;
    return raw + this.#turns * 2 ** 32;
  }
}

/**
 * Maps a sensor's microseconds to the page's milliseconds: in each of ten blocks of three seconds the message that was
 * quickest, and a line through these. It learns from each message before it places any of the same moment.
 */
export class DeviceClock {
  readonly #blocks: Block[] = [];
  #offsetMs = Number.NaN;

  /** Learn from a message when it arrives. */
  learn(deviceUs: number, arrivalMs: number): void {
    const delayMs = arrivalMs - deviceUs / 1000;
    const block = this.#blocks.at(-1);
    if (!block || deviceUs - block.startUs > BLOCK_US) {
      this.#blocks.push({ startUs: deviceUs, deviceUs, leastMs: delayMs });
      if (this.#blocks.length > BLOCKS) this.#blocks.shift();
    } else if (delayMs < block.leastMs) {
      block.deviceUs = deviceUs;
      block.leastMs = delayMs;
    }
  }

  /** The page's time at which this was measured; of rising times. */
  place(deviceUs: number): number {
    const wantedMs = this.#line(deviceUs);
    if (Number.isNaN(this.#offsetMs)) this.#offsetMs = wantedMs;
    const leftMs = wantedMs - this.#offsetMs;
    const most = Math.abs(leftMs) > FAR_MS ? FAR_SLEW_MS : SLEW_MS;
    this.#offsetMs += Math.max(-most, Math.min(most, leftMs));
    return deviceUs / 1000 + this.#offsetMs;
  }

  #line(deviceUs: number): number {
    const lowest = Math.min(...this.#blocks.map((one) => one.leastMs));
    const blocks = this.#blocks.filter((one) => one.leastMs < lowest + STALLED_MS);
    // A line wants some length; before, the quickest message of all counts.
    if (blocks.length < 4) return lowest;
    const meanUs = blocks.reduce((sum, one) => sum + one.deviceUs, 0) / blocks.length;
    const meanMs = blocks.reduce((sum, one) => sum + one.leastMs, 0) / blocks.length;
    let across = 0;
    let along = 0;
    for (const one of blocks) {
      across += (one.deviceUs - meanUs) * (one.leastMs - meanMs);
      along += (one.deviceUs - meanUs) ** 2;
    }
    const most = MOST_SKEW / 1000;
    const slope = Math.max(-most, Math.min(most, across / along));
    return meanMs + slope * (deviceUs - meanUs);
  }
}
