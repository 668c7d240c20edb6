// A gateway's side of `/ws/ingest` in the browser: send what is stored, forget what is acknowledged, send again what is
// missing. The rules are those of docs/packet.md; everything that is sent is read from the store of this device.
import type { Sentence } from '../../i18n/sentence';
import { backfilled } from './packet';
import type { PacketStore, StoredNetwork } from './store';

export type LinkStatus = 'connecting' | 'open' | 'lost' | 'refused' | 'ended';

export interface LinkState {
  status: LinkStatus;
  /** Code of the service's refusal. */
  code: string;
  /** The service's own words for it, and what they say, for the reader's language. */
  reason: string;
  sentence: Sentence | null;
  /** Everything up to and including this sequence is safe with the service. */
  acknowledged: number;
  /** Highest sequence that the service has. */
  highest: number;
  /** Of the session, as the service says it. */
  sessionState: string;
  sent: number;
  /** Sent again after a break or on request. */
  resent: number;
  connections: number;
  /** The service answers over HTTP, and the network between refuses the socket. */
  isBlocked: boolean;
}

/** What the ticket's request was refused with; no code where the service was not reached. */
export interface Refusal {
  code: string;
  reason: string;
  /** What the reason says; none where it is in the reader's language already. */
  sentence?: Sentence | undefined;
}

export interface LinkOptions {
  url: string;
  network: StoredNetwork;
  store: PacketStore;
  /** A fresh ticket for each connection. Rejects with a `Refusal`. */
  ticket: () => Promise<string>;
  onState: (state: LinkState) => void;
  create?: (url: string) => WebSocket;
  random?: () => number;
}

interface Acknowledge {
  type: 'acknowledge';
  acknowledged: number;
  highest: number;
  missing: [number, number][];
  state: string;
}

interface Fault {
  type: 'error';
  code: string;
  message: string;
  closing: boolean;
  details?: { reason?: string };
  sentences?: { message?: Sentence };
}

const FIRST_WAIT_MS = 250;
const LONGEST_WAIT_MS = 5000;
/** The service acknowledges once a second; a link that says nothing for so long is broken. */
const SILENT_MS = 6000;
/** So many tickets in a row were given, and the socket that each was for heard no word. */
const BLOCKED_AFTER = 3;
const SEND_AGAIN_MS = 1000;
const BATCH = 50;
/** The browser holds what it has not sent yet in memory: more waits in the store. */
const WAITING_BYTES = 64 * 1024;
const DRAIN_MS = 20;
/** Refusals that another try with a fresh ticket may mend. */
const PASSING = new Set(['', 'offline', 'unavailable', 'too_many_attempts', 'limit_reached', 'internal', 'unknown']);
const OVER = new Set(['closing', 'analysed', 'failed']);

/** Another device that took over is a conflict as an ended session is one: the reason tells them apart. */
function refusalOf({ code, message, details, sentences }: Fault): Refusal {
  return {
    code: details?.reason === 'superseded' ? 'superseded' : code,
    reason: message,
    sentence: sentences?.message,
  };
}

export class Link {
  readonly #options: LinkOptions;
  #state: LinkState = {
    status: 'connecting',
    code: '',
    reason: '',
    sentence: null,
    acknowledged: -1,
    highest: -1,
    sessionState: '',
    sent: 0,
    resent: 0,
    connections: 0,
    isBlocked: false,
  };
  #socket: WebSocket | null = null;
  /** Moves on with each connection and each loss: what an earlier turn still waited for comes to nothing. */
  #turn = 0;
  #isGreeted = false;
  /** Connections in a row for which there was a ticket, and then no word. */
  #mute = 0;
  #attempt = 0;
  #timer: ReturnType<typeof setTimeout> | undefined;
  #watch: ReturnType<typeof setTimeout> | undefined;
  #isDone = false;
  /** The first sequence that was not sent over this connection. */
  #next = 0;
  /** Sequences below are sent as back-filled: they were stored before this connection. */
  #liveFrom = 0;
  #stored = -1;
  #isSending = false;
  #askedMs = new Map<number, number>();
  #last: number | null = null;
  /** The connection that has heard the goodbye. */
  #saidTo: WebSocket | null = null;

  constructor(options: LinkOptions) {
    this.#options = options;
  }

  get state(): LinkState {
    return this.#state;
  }

  async begin(): Promise<void> {
    const turn = this.#turn;
    this.#stored = Math.max(this.#stored, await this.#options.store.highest(this.#options.network.sessionId));
    if (turn === this.#turn) void this.#connect();
  }

  /** A packet is in the store. */
  stored(sequence: number): void {
    this.#stored = Math.max(this.#stored, sequence);
    void this.#send();
  }

  /** No packet above this will come: the session closes when everything is stored by the service. */
  finish(last: number): void {
    this.#last = last;
    void this.#send();
  }

  /** Let go of the connection and open another: after a pause the service must hear a new hello. */
  renew(): void {
    if (this.#isDone) return;
    this.#attempt = 0;
    this.#lost();
  }

  close(): void {
    this.#isDone = true;
    clearTimeout(this.#timer);
    this.#drop();
  }

  #say(change: Partial<LinkState>): void {
    this.#state = { ...this.#state, ...change };
    this.#options.onState(this.#state);
  }

  #drop(): void {
    this.#turn += 1;
    clearTimeout(this.#watch);
    const socket = this.#socket;
    this.#socket = null;
    this.#isGreeted = false;
    if (!socket) return;
    socket.onopen = socket.onmessage = socket.onclose = null;
    socket.close();
  }

  #lost(): void {
    this.#drop();
    if (this.#isDone) return;
    this.#say({ status: 'lost', isBlocked: this.#mute >= BLOCKED_AFTER });
    const waitMs = Math.min(LONGEST_WAIT_MS, FIRST_WAIT_MS * 2 ** this.#attempt);
    this.#attempt += 1;
    clearTimeout(this.#timer);
    this.#timer = setTimeout(
      () => void this.#connect(),
      waitMs * (0.5 + 0.5 * (this.#options.random ?? Math.random)()),
    );
  }

  #end(status: 'refused' | 'ended', refusal: Refusal): void {
    this.close();
    this.#say({ status, code: refusal.code, reason: refusal.reason, sentence: refusal.sentence ?? null });
  }

  #refused(refusal: Refusal): void {
    if (PASSING.has(refusal.code)) this.#lost();
    else this.#end('refused', refusal);
  }

  async #connect(): Promise<void> {
    this.#drop();
    clearTimeout(this.#timer);
    const turn = this.#turn;
    let ticket: string;
    try {
      ticket = await this.#options.ticket();
    } catch (error) {
      if (turn !== this.#turn) return;
      this.#mute = 0;
      this.#refused(error as Refusal);
      return;
    }
    if (turn !== this.#turn) return;
    this.#mute += 1;
    const { url, network } = this.#options;
    const socket = (this.#options.create ?? ((address) => new WebSocket(address)))(url);
    this.#socket = socket;
    socket.binaryType = 'arraybuffer';
    this.#watched();
    socket.onopen = () => {
      const hello = {
        type: 'hello',
        protocol_version: 1,
        ticket,
        placements: network.placements,
        rate_hz: network.rateHz,
        device: network.device,
        firmware: '1',
      };
      socket.send(JSON.stringify(hello));
    };
    socket.onmessage = (event: MessageEvent<string>) => {
      this.#mute = 0;
      this.#watched();
      const message = JSON.parse(event.data) as Acknowledge | Fault;
      if (message.type === 'acknowledge') void this.#acknowledged(message);
      else if (message.type === 'error' && message.closing) this.#refused(refusalOf(message));
    };
    socket.onclose = () => this.#lost();
  }

  #watched(): void {
    clearTimeout(this.#watch);
    this.#watch = setTimeout(() => this.#lost(), SILENT_MS);
  }

  async #acknowledged(message: Acknowledge): Promise<void> {
    const { store, network } = this.#options;
    const turn = this.#turn;
    const isFirst = !this.#isGreeted;
    const isNews = message.acknowledged > this.#state.acknowledged;
    if (isFirst) {
      this.#isGreeted = true;
      this.#attempt = 0;
      this.#next = message.highest + 1;
      this.#liveFrom = this.#stored + 1;
      this.#askedMs.clear();
    }
    // Forgotten first: whoever hears of it counts what is left.
    if (isNews || isFirst) {
      await store.forget(network.sessionId, message.acknowledged);
      for (const sequence of this.#askedMs.keys()) if (sequence <= message.acknowledged) this.#askedMs.delete(sequence);
    }
    const isOpen = turn === this.#turn;
    this.#say({
      // The connection may have been lost while the store forgot.
      status: isOpen ? 'open' : this.#state.status,
      isBlocked: false,
      acknowledged: Math.max(this.#state.acknowledged, message.acknowledged),
      highest: Math.max(this.#state.highest, message.highest),
      sessionState: message.state,
      connections: this.#state.connections + (isFirst ? 1 : 0),
    });
    if (OVER.has(message.state)) return this.#end('ended', { code: message.state, reason: '' });
    if (!isOpen) return;
    for (const [start, stop] of message.missing) await this.#sendAgain(start, Math.min(stop, this.#next) - 1);
    void this.#send();
  }

  /** Send everything that is stored and was not sent over this connection, in order, then the goodbye. */
  async #send(): Promise<void> {
    if (this.#isSending) return;
    this.#isSending = true;
    try {
      while (this.#isGreeted && this.#next <= this.#stored) {
        const socket = this.#socket;
        const found = await this.#options.store.read(this.#options.network.sessionId, this.#next, BATCH);
        // What was given up is not here, and what another key sealed cannot be sent; nothing else is left out.
        if (found.length === 0) this.#next = this.#stored + 1;
        for (const one of found) {
          // Another connection has another beginning.
          if (!(await this.#drained(socket))) break;
          const isLate = one.sequence < this.#liveFrom;
          socket?.send(isLate ? (backfilled(one.bytes) as Uint8Array<ArrayBuffer>) : one.bytes);
          this.#next = one.sequence + 1;
          this.#count(isLate);
        }
      }
      const isAllSent = this.#isGreeted && this.#last !== null && this.#next > this.#last;
      if (isAllSent && this.#saidTo !== this.#socket) {
        this.#saidTo = this.#socket;
        this.#socket?.send(JSON.stringify({ type: 'goodbye', last_sequence: this.#last }));
      }
    } finally {
      this.#isSending = false;
    }
  }

  async #sendAgain(start: number, last: number): Promise<void> {
    if (last < start) return;
    const socket = this.#socket;
    const nowMs = performance.now();
    const found = await this.#options.store.read(this.#options.network.sessionId, start, BATCH, last);
    for (const one of found) {
      if (nowMs - (this.#askedMs.get(one.sequence) ?? -Infinity) < SEND_AGAIN_MS) continue;
      if (!(await this.#drained(socket))) return;
      this.#askedMs.set(one.sequence, nowMs);
      socket?.send(backfilled(one.bytes) as Uint8Array<ArrayBuffer>);
      this.#count(true);
    }
  }

  /** Wait until the browser has sent what it holds; false when the link is another meanwhile. */
  async #drained(socket: WebSocket | null): Promise<boolean> {
    while (socket && socket === this.#socket && socket.bufferedAmount > WAITING_BYTES)
      await new Promise((resolve) => setTimeout(resolve, DRAIN_MS));
    return socket !== null && socket === this.#socket && this.#isGreeted;
  }

  #count(isAgain: boolean): void {
    this.#state = {
      ...this.#state,
      sent: this.#state.sent + 1,
      resent: this.#state.resent + (isAgain ? 1 : 0),
    };
  }
}
