// The contract between whatever moves and whatever shows it. Live view and replay are the same to a view:
// a clock, capabilities, a connection, frames. Seeking means: forget what you hold.
import type { LayoutMessage } from '../api/types';

export type Connection =
  /** Being opened for the first time. */
  | 'connecting'
  | 'open'
  /** Was open; being tried again. */
  | 'lost'
  /** The service said no, or speaks another protocol; it is not tried again. */
  | 'refused'
  | 'closed';

export interface Capabilities {
  isLive: boolean;
  canSeek: boolean;
  canChangeSpeed: boolean;
}

/** Where the player stands. In a live session `timeS` is the newest frame and `endS` follows it. */
export interface Clock {
  timeS: number;
  startS: number;
  endS: number;
  isPlaying: boolean;
  speed: number;
}

/** Names of the columns, and where each is found. */
export interface Columns {
  layout: LayoutMessage['layout'];
  names: readonly string[];
  index: ReadonlyMap<string, number>;
  rateHz: number;
  /** By so much the frames show what was, beside the way of the packets. */
  delayS: number;
}

/** A stretch of frames, one array a column, in the order asked for. */
export interface Stretch {
  timeS: Float64Array;
  values: Float32Array[];
  /** False while a part of the stretch is still on its way. */
  isComplete: boolean;
}

/** What changes seldom enough to draw a page from. */
export interface PlayerSnapshot {
  connection: Connection;
  /** Why the connection is lost or refused, in words. */
  problem: string | null;
  capabilities: Capabilities;
  columns: Columns | null;
  isPlaying: boolean;
  speed: number;
  /** Changes when everything that was read before must be forgotten. */
  epoch: number;
}

export interface Player {
  getSnapshot(): PlayerSnapshot;
  /** Call back when the snapshot changes; returns how to stop. */
  subscribe(listener: () => void): () => void;
  /** Cheap enough to ask for every picture. */
  clock(): Clock;
  /** Frames in the half-open interval, at most `maxPoints`; missing columns come as empty arrays. */
  read(startS: number, endS: number, columns: readonly string[], maxPoints?: number): Stretch;
  play(): void;
  pause(): void;
  seek(timeS: number): void;
  setSpeed(speed: number): void;
  close(): void;
}

/** Make the look-up of a layout message. */
export function columnsOf(message: LayoutMessage): Columns {
  return {
    layout: message.layout,
    names: message.columns,
    index: new Map(message.columns.map((name, position) => [name, position])),
    rateHz: message.rate_hz,
    delayS: message.delay_s ?? 0,
  };
}

/** Holds a snapshot and tells whoever listens when it changes. */
export class SnapshotStore<S extends object> {
  #value: S;
  readonly #listeners = new Set<() => void>();

  constructor(value: S) {
    this.#value = value;
  }

  get = (): S => this.#value;

  set(change: Partial<S>): void {
    const differs = (Object.keys(change) as (keyof S)[]).some((name) => !Object.is(change[name], this.#value[name]));
    if (!differs) return;
    this.#value = { ...this.#value, ...change };
    for (const listener of this.#listeners) listener();
  }

  subscribe = (listener: () => void): (() => void) => {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  };
}
