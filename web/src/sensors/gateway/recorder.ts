// The whole of a gateway but its sensors: samples in; packets stored, sent, acknowledged and forgotten.
import { Grid, type Sample, type Tick } from './grid';
import { Link, type LinkOptions, type LinkState } from './link';
import { encodePacket, MOTION } from './packet';
import type { PacketStore, StoredNetwork } from './store';

const TICKS_A_PACKET = 6;
/** Packets that wait for the database, at most; then it is said that storing fails. */
const WAITING_PACKETS = 600;
/** After such a pause the clock of the packets jumps, which the service takes only after a hello. */
const RENEW_AFTER_MS = 30_000;

/** What a page shows of it. */
export interface RecorderState {
  link: LinkState;
  /** Packets on this device that are not yet safe with the service. */
  waiting: number;
  /** Seconds of movement in them. */
  waitingS: number;
  /** Packets written since the page was opened. */
  stored: number;
  /** This device refuses to store: what cannot be sent is lost. */
  isFull: boolean;
  lostPackets: number;
  /** No more samples come, and the last are on this device or safe: `waiting` counts them all. */
  isComplete: boolean;
}

export interface RecorderOptions extends Pick<LinkOptions, 'url' | 'ticket' | 'create' | 'random'> {
  network: StoredNetwork;
  store: PacketStore;
  onState: (state: RecorderState) => void;
}

export class Recorder {
  readonly #options: RecorderOptions;
  readonly #link: Link;
  readonly #grid: Grid;
  #ticks: Tick[] = [];
  #sequence = 0;
  #lastMs = Number.NaN;
  /** Packets in order; each is written before the next. */
  #writing: Promise<void> = Promise.resolve();
  #inHand = 0;
  #isFinished = false;
  #state: RecorderState;

  constructor(options: RecorderOptions) {
    const { network, store } = options;
    this.#options = options;
    this.#grid = new Grid(network.placements.length, network.rateHz);
    this.#link = new Link({ ...options, network, store, onState: (link) => void this.#heard(link) });
    this.#state = {
      link: this.#link.state,
      waiting: 0,
      waitingS: 0,
      stored: 0,
      isFull: false,
      lostPackets: 0,
      isComplete: false,
    };
  }

  get state(): RecorderState {
    return this.#state;
  }

  /** Go on numbering after everything that was stored or sent before. */
  async begin(): Promise<void> {
    const { network, store } = this.#options;
    const known = await store.next(network.sessionId);
    this.#sequence = Math.max(known, (await store.highest(network.sessionId)) + 1);
    await store.declare({ ...network, next: this.#sequence });
    await this.#count();
    await this.#link.begin();
  }

  /** Take one sample; `timeMs` is the time of this device's clock at which it was measured. */
  add(sensor: number, timeMs: number, sample: Sample): void {
    if (this.#isFinished || !sample.every(Number.isFinite)) return;
    if (timeMs - this.#lastMs > RENEW_AFTER_MS) this.#link.renew();
    this.#lastMs = Number.isNaN(this.#lastMs) ? timeMs : Math.max(this.#lastMs, timeMs);
    for (const tick of this.#grid.add(sensor, timeMs, sample)) this.#tick(tick);
  }

  /** A sensor is gone: its ticks are missing from now on, and the others do not wait for it. */
  leave(sensor: number): void {
    this.#grid.leave(sensor);
  }

  /** Write what is there, also where it does not fill a packet: the page may be gone in a moment. */
  async flush(): Promise<void> {
    for (const tick of this.#grid.rest()) this.#tick(tick);
    this.#pack();
    await this.#writing;
  }

  /** No more samples come. With a goodbye the service closes the session when all of it is stored. */
  async finish(isGoodbye: boolean): Promise<void> {
    this.#isFinished = true;
    await this.flush();
    this.#say({ isComplete: true });
    if (isGoodbye) this.#link.finish(this.#sequence - 1);
  }

  async close(): Promise<void> {
    await this.finish(false);
    this.#link.close();
  }

  #tick(tick: Tick): void {
    const last = this.#ticks.at(-1);
    if (last && tick.number !== last.number + 1) this.#pack();
    this.#ticks.push(tick);
    if (this.#ticks.length === TICKS_A_PACKET) this.#pack();
  }

  #pack(): void {
    const first = this.#ticks[0];
    if (!first) return;
    const { network, store } = this.#options;
    const sequence = this.#sequence;
    const width = first.values.length;
    const values = new Float32Array(width * this.#ticks.length);
    this.#ticks.forEach((tick, at) => values.set(tick.values, at * width));
    const bytes = encodePacket({
      sequence,
      deviceTimeUs: BigInt(Math.round((first.number * 1e6) / network.rateHz)),
      tickIntervalUs: Math.round(1e6 / network.rateHz),
      sensors: network.placements.length,
      ticks: this.#ticks.length,
      channels: MOTION,
      values,
    });
    this.#ticks = [];
    if (this.#inHand >= WAITING_PACKETS) {
      this.#say({ isFull: true, lostPackets: this.#state.lostPackets + 1 });
      return;
    }
    this.#sequence += 1;
    this.#inHand += 1;
    this.#writing = this.#writing.then(() => this.#write(store, sequence, bytes));
  }

  async #write(store: PacketStore, sequence: number, bytes: Uint8Array<ArrayBuffer>): Promise<void> {
    try {
      await store.put(this.#options.network.sessionId, sequence, bytes);
      this.#link.stored(sequence);
      this.#say({ stored: this.#state.stored + 1, isFull: false, ...this.#waiting(this.#state.waiting + 1) });
    } catch {
      this.#say({ isFull: true, lostPackets: this.#state.lostPackets + 1 });
    } finally {
      this.#inHand -= 1;
    }
  }

  async #heard(link: LinkState): Promise<void> {
    const isNews = link.acknowledged !== this.#state.link.acknowledged || link.status !== this.#state.link.status;
    // Another device sent for this session before: what comes now follows it.
    if (link.highest >= this.#sequence) this.#sequence = link.highest + 1;
    this.#say({ link });
    // A packet that was being written while it was counted must not seem to wait for good.
    if (isNews || this.#state.waiting > 0) await this.#count();
    if (link.status === 'ended' && this.#state.waiting === 0)
      await this.#options.store.remove(this.#options.network.sessionId);
  }

  async #count(): Promise<void> {
    const { store, network } = this.#options;
    this.#say(this.#waiting(await store.count(network.sessionId)));
  }

  #waiting(packets: number): Pick<RecorderState, 'waiting' | 'waitingS'> {
    return { waiting: packets, waitingS: (packets * TICKS_A_PACKET) / this.#options.network.rateHz };
  }

  #say(change: Partial<RecorderState>): void {
    this.#state = { ...this.#state, ...change };
    this.#options.onState(this.#state);
  }
}
