// A stored session: pages of frames fetched when they are near, a clock of our own, the same contract as live.
import { address, ofSession } from '../api/address';
import { api } from '../api/client';
import { PROTOCOL_VERSION } from '../api/schema';
import { t } from '../i18n';
import type { Block } from './block';
import { createDecoder, type Decoder } from './decoder';
import { columnsOf, SnapshotStore, type Clock, type Player, type PlayerSnapshot, type Stretch } from './types';

/** Seconds in a page, and how many are held: at 100 Hz and 100 columns about 16 MB. */
export const PAGE_S = 10;
export const PAGES_HELD = 40;
const OVERVIEW_POINTS = 2000;

export interface ReplayPlayerOptions {
  sessionId: string;
  resultId: string | null;
  startS: number;
  endS: number;
  decoder?: Decoder;
  /** Wall clock in ms; for tests. */
  now?: () => number;
}

export class ReplayPlayer implements Player {
  readonly #options: ReplayPlayerOptions;
  readonly #store: SnapshotStore<PlayerSnapshot>;
  readonly #decoder: Decoder;
  readonly #now: () => number;
  readonly #pages = new Map<number, Block>();
  readonly #asked = new Map<number, AbortController>();
  #overview: Block | null = null;
  /** Session time at the moment `#sinceMs`; the clock runs on from there while playing. */
  #baseS: number;
  #sinceMs = 0;

  constructor(options: ReplayPlayerOptions) {
    this.#options = options;
    this.#decoder = options.decoder ?? createDecoder();
    this.#now = options.now ?? (() => performance.now());
    this.#baseS = options.startS;
    this.#store = new SnapshotStore<PlayerSnapshot>({
      connection: 'connecting',
      problem: null,
      capabilities: { isLive: false, canSeek: true, canChangeSpeed: true },
      columns: null,
      isPlaying: false,
      speed: 1,
      epoch: 0,
    });
    void this.#open();
  }

  getSnapshot = () => this.#store.get();
  subscribe = (listener: () => void) => this.#store.subscribe(listener);

  clock(): Clock {
    const { isPlaying, speed } = this.#store.get();
    const { startS, endS } = this.#options;
    const ran = isPlaying ? ((this.#now() - this.#sinceMs) / 1000) * speed : 0;
    const timeS = Math.min(endS, this.#baseS + ran);
    if (isPlaying && timeS >= endS) {
      this.#baseS = endS;
      // Not in the middle of whoever is drawing: the end is reported right after.
      queueMicrotask(() => this.#store.set({ isPlaying: false }));
    }
    return { timeS, startS, endS, isPlaying, speed };
  }

  /** Frames of the interval at full rate where the pages are here, else from the overview until they are. */
  read(startS: number, endS: number, columns: readonly string[], maxPoints = Infinity): Stretch {
    const known = this.#store.get().columns;
    if (!known || !this.#overview)
      return { timeS: new Float64Array(0), values: columns.map(() => new Float32Array(0)), isComplete: false };
    const spanPoints = (endS - startS) * known.rateHz;
    if (spanPoints > maxPoints || endS - startS > PAGE_S * (PAGES_HELD / 2))
      return cut([this.#overview], startS, endS, known.index, columns, true);
    const first = Math.floor(Math.max(startS, this.#options.startS) / PAGE_S);
    const last = Math.ceil(Math.min(endS, this.#options.endS) / PAGE_S);
    const pages: Block[] = [];
    let isComplete = true;
    for (let page = first; page < last; page += 1) {
      const held = this.#pages.get(page);
      if (held) {
        this.#pages.delete(page);
        this.#pages.set(page, held);
        pages.push(held);
      } else {
        isComplete = false;
        void this.#fetchPage(page);
      }
    }
    return isComplete
      ? cut(pages, startS, endS, known.index, columns, true)
      : cut([this.#overview], startS, endS, known.index, columns, false);
  }

  play(): void {
    const { timeS, startS, endS } = this.clock();
    this.#baseS = timeS >= endS ? startS : timeS;
    this.#sinceMs = this.#now();
    this.#store.set({ isPlaying: true });
  }

  pause(): void {
    this.#baseS = this.clock().timeS;
    this.#store.set({ isPlaying: false });
  }

  seek(timeS: number): void {
    this.#baseS = Math.min(this.#options.endS, Math.max(this.#options.startS, timeS));
    this.#sinceMs = this.#now();
    // What was asked for elsewhere is not wanted any more.
    const page = Math.floor(this.#baseS / PAGE_S);
    for (const [number, controller] of this.#asked) if (Math.abs(number - page) > 2) controller.abort();
    this.#store.set({ epoch: this.#store.get().epoch + 1 });
  }

  setSpeed(speed: number): void {
    this.#baseS = this.clock().timeS;
    this.#sinceMs = this.#now();
    this.#store.set({ speed });
  }

  close(): void {
    for (const controller of this.#asked.values()) controller.abort();
    this.#decoder.close();
    this.#store.set({ connection: 'closed', isPlaying: false });
  }

  async #open(): Promise<void> {
    const { sessionId, resultId, startS, endS } = this.#options;
    try {
      const message = await api.get(
        address('/api/sessions/{session_id}/layout', { ...ofSession(sessionId), query: { result_id: resultId } }),
      );
      if (message.protocol_version !== PROTOCOL_VERSION) {
        this.#store.set({
          connection: 'refused',
          problem: t('player.otherVersion', { ours: PROTOCOL_VERSION, theirs: message.protocol_version ?? '?' }),
        });
        return;
      }
      this.#overview = await this.#fetchBlock(startS, endS, OVERVIEW_POINTS);
      if (this.#store.get().connection === 'closed') return;
      this.#store.set({
        connection: 'open',
        problem: null,
        columns: columnsOf(message),
        epoch: this.#store.get().epoch + 1,
      });
    } catch (error) {
      if (this.#store.get().connection === 'closed') return;
      this.#store.set({ connection: 'refused', problem: error instanceof Error ? error.message : String(error) });
    }
  }

  async #fetchBlock(startS: number, endS: number, maxPoints: number | null, signal?: AbortSignal): Promise<Block> {
    const { sessionId, resultId } = this.#options;
    const at = address('/api/sessions/{session_id}/frames', {
      ...ofSession(sessionId),
      query: { result_id: resultId, start_s: startS, end_s: endS, max_points: maxPoints },
    });
    return this.#decoder.decode(await api.binary(at, signal));
  }

  async #fetchPage(page: number): Promise<void> {
    if (this.#asked.has(page)) return;
    const controller = new AbortController();
    this.#asked.set(page, controller);
    try {
      const block = await this.#fetchBlock(page * PAGE_S, (page + 1) * PAGE_S, null, controller.signal);
      this.#pages.set(page, block);
      for (const oldest of this.#pages.keys()) {
        if (this.#pages.size <= PAGES_HELD) break;
        this.#pages.delete(oldest);
      }
      this.#asked.delete(page);
      this.#store.set({ connection: 'open', problem: null, epoch: this.#store.get().epoch + 1 });
    } catch (error) {
      const wasWanted = !controller.signal.aborted;
      if (wasWanted && this.#store.get().connection !== 'closed') {
        this.#store.set({ connection: 'lost', problem: error instanceof Error ? error.message : String(error) });
        // Asked for again by the next picture, but not before a moment has passed.
        await new Promise((resolve) => setTimeout(resolve, 2000));
      }
      this.#asked.delete(page);
    }
  }
}

/** The ticks of the interval out of blocks in time order. */
function cut(
  blocks: readonly Block[],
  startS: number,
  endS: number,
  index: ReadonlyMap<string, number>,
  names: readonly string[],
  isComplete: boolean,
): Stretch {
  const ranges = blocks.map((block) => {
    const at = (timeS: number) =>
      Math.min(block.ticks, Math.max(0, Math.ceil((timeS - block.startS) / block.stepS - 1e-6)));
    return { block, from: at(startS), until: at(endS) };
  });
  const size = ranges.reduce((sum, { from, until }) => sum + Math.max(0, until - from), 0);
  const timeS = new Float64Array(size);
  const values = names.map((name) => new Float32Array(index.has(name) ? size : 0));
  let out = 0;
  for (const { block, from, until } of ranges) {
    for (let tick = from; tick < until; tick += 1) timeS[out + tick - from] = block.startS + tick * block.stepS;
    names.forEach((name, position) => {
      const column = index.get(name);
      const source = column === undefined ? undefined : block.columns[column];
      if (source && until > from) values[position]?.set(source.subarray(from, until), out);
    });
    out += Math.max(0, until - from);
  }
  return { timeS, values, isComplete };
}
