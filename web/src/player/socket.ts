// A WebSocket that comes back. What it says of the connection is judged by answers: the service says something once a
// second, so a socket that is quiet is lost although it never closed. It stops when the service said no.
import { REACH_S, serviceAnswers } from './reach';

export type SocketStatus = 'connecting' | 'open' | 'lost' | 'refused' | 'closed';

export interface SocketState {
  status: SocketStatus;
  /** Why it is lost or refused, in words; empty where nobody said. */
  reason: string;
  /** Since when nothing is heard, s since the epoch: one moment, until something is heard again. */
  lostSinceS: number | null;
  /** The service answers over HTTP, and no socket gets through to it: the network between refuses them. */
  isBlocked: boolean;
}

export const CONNECTING: SocketState = { status: 'connecting', reason: '', lostSinceS: null, isBlocked: false };

export interface ReturningSocketOptions {
  url: string;
  onText?: (text: string) => void;
  onBinary?: (buffer: ArrayBuffer) => void;
  /** A new connection: nothing that was said over the one before counts any more. */
  onOpen?: () => void;
  onState: (state: SocketState) => void;
  random?: () => number;
  create?: (url: string) => WebSocket;
  /** The wall clock, s. */
  now?: () => number;
  /** Whether the service answers over HTTP. */
  answers?: () => Promise<boolean>;
}

const FIRST_DELAY_MS = 500;
const LONGEST_DELAY_MS = 15_000;
/** A try that is not answered for so long will not be: the network was away when it began. */
const OPEN_TIMEOUT_MS = 6000;
/** A socket that says nothing for so long is opened anew; a network that went away closes nothing. */
const GIVE_UP_S = 8;
/** Nothing ran here for so long, no timer and no message: the machine slept, and what still arrives is of before. */
const SLEPT_S = 5;
const LOOK_MS = 250;
/** While it is lost, HTTP is asked so often; the last quarter by chance. */
const ASK_MS = 2500;
/** Tries without a word, and answers over HTTP between them, that tell a network that refuses from a service that starts. */
const BLOCKED_AFTER = 2;
/** Close codes after which another try cannot help: policy, and the service's own refusals. */
const isRefusal = (code: number) => code === 1008 || code === 1003 || (code >= 4400 && code < 4500);

/** Wait before the given try (0 is the first after a loss): doubles up to 15 s, a quarter of it by chance. */
export function backOffMs(attempt: number, random: () => number = Math.random): number {
  const base = Math.min(LONGEST_DELAY_MS, FIRST_DELAY_MS * 2 ** attempt);
  return base * (0.75 + 0.25 * random());
}

export class ReturningSocket {
  readonly #options: ReturningSocketOptions;
  readonly #nowS: () => number;
  readonly #look: ReturnType<typeof setInterval>;
  readonly #begunS: number;
  #state = CONNECTING;
  #socket: WebSocket | null = null;
  #attempt = 0;
  #timer: ReturnType<typeof setTimeout> | undefined;
  #asking: ReturnType<typeof setTimeout> | undefined;
  #isDone = false;
  /** When the service was last heard; 0 before its first word. */
  #heardS = 0;
  /** From when on a word is due: since the socket is open, or since the last one. */
  #dueS = 0;
  #ranS: number;
  #isSpoken = false;
  /** Tries in a row that brought no word, and answers in a row over HTTP. */
  #mute = 0;
  #answers = 0;

  constructor(options: ReturningSocketOptions) {
    this.#options = options;
    this.#nowS = options.now ?? (() => Date.now() / 1000);
    this.#begunS = this.#ranS = this.#nowS();
    this.#look = setInterval(() => this.#watch(), LOOK_MS);
    globalThis.addEventListener?.('online', this.#online);
    this.#connect();
  }

  get isOpen(): boolean {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  get heardS(): number {
    return this.#heardS;
  }

  send(message: object): void {
    if (this.isOpen) this.#socket?.send(JSON.stringify(message));
  }

  /** Stop for good because the two sides cannot understand each other. */
  refuse(reason: string): void {
    if (this.#isDone) return;
    this.#finish();
    this.#say({ status: 'refused', reason, lostSinceS: null, isBlocked: false });
  }

  close(): void {
    if (this.#isDone) return;
    this.#finish();
    this.#say({ status: 'closed', reason: '', lostSinceS: null, isBlocked: false });
  }

  /** Whoever reads it misses more than words: call it lost until the next word. */
  doubt(): void {
    if (!this.#isDone && this.#state.status === 'open') this.#lose('');
  }

  #say(change: Partial<SocketState>): void {
    this.#state = { ...this.#state, ...change };
    this.#options.onState(this.#state);
  }

  #finish(): void {
    this.#isDone = true;
    clearTimeout(this.#timer);
    clearTimeout(this.#asking);
    clearInterval(this.#look);
    globalThis.removeEventListener?.('online', this.#online);
    this.#socket?.close();
  }

  /** Forget the present socket: it takes long to close where nobody answers. */
  #drop(): void {
    clearTimeout(this.#timer);
    const socket = this.#socket;
    this.#socket = null;
    if (!socket) return;
    socket.onopen = socket.onmessage = socket.onclose = null;
    socket.close();
  }

  #connect(): void {
    this.#drop();
    const socket = (this.#options.create ?? ((url) => new WebSocket(url)))(this.#options.url);
    this.#socket = socket;
    this.#isSpoken = false;
    this.#dueS = this.#nowS();
    socket.binaryType = 'arraybuffer';
    this.#timer = setTimeout(() => this.#failed(''), OPEN_TIMEOUT_MS);
    socket.onopen = () => {
      clearTimeout(this.#timer);
      this.#dueS = this.#nowS();
      this.#options.onOpen?.();
    };
    socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => {
      if (this.#isDone || this.#hasSlept()) return;
      this.#heard();
      if (typeof event.data === 'string') this.#options.onText?.(event.data);
      else this.#options.onBinary?.(event.data);
    };
    socket.onclose = (event) => {
      if (this.#isDone) return;
      if (!isRefusal(event.code)) return this.#failed(event.reason);
      this.#finish();
      this.#say({ status: 'refused', reason: event.reason, lostSinceS: null, isBlocked: false });
    };
  }

  #heard(): void {
    this.#heardS = this.#dueS = this.#nowS();
    this.#isSpoken = true;
    this.#attempt = this.#mute = 0;
    if (this.#state.status === 'open') return;
    clearTimeout(this.#asking);
    this.#say({ status: 'open', reason: '', lostSinceS: null, isBlocked: false });
  }

  /** Whether nothing ran here for a while: then all that was on its way is old, and another socket is opened. */
  #hasSlept(): boolean {
    const nowS = this.#nowS();
    const sleptS = nowS - this.#ranS;
    this.#ranS = nowS;
    if (sleptS < SLEPT_S || !this.isOpen) return false;
    this.#again();
    return true;
  }

  #watch(): void {
    if (this.#hasSlept() || !this.isOpen) return;
    const quietS = this.#nowS() - this.#dueS;
    if (quietS > REACH_S && this.#state.status === 'open') this.#lose('');
    if (quietS > GIVE_UP_S) {
      if (!this.#isSpoken) this.#mute += 1;
      this.#again();
    }
  }

  readonly #online = () => {
    if (this.#state.status === 'lost') this.#again();
  };

  /** Open another socket now. */
  #again(): void {
    if (this.#state.status !== 'lost') this.#lose('');
    this.#connect();
  }

  #failed(reason: string): void {
    this.#drop();
    if (!this.#isSpoken) this.#mute += 1;
    this.#lose(reason);
    const delay = backOffMs(this.#attempt, this.#options.random);
    this.#attempt += 1;
    this.#timer = setTimeout(() => this.#connect(), delay);
  }

  #lose(reason: string): void {
    const isNews = this.#state.status !== 'lost';
    const lostSinceS = this.#state.lostSinceS ?? (this.#heardS || this.#begunS);
    this.#say({ status: 'lost', reason: reason || this.#state.reason, lostSinceS });
    if (!isNews) return;
    // A network that is away is asked again; one that answers now may have answered all the time.
    this.#answers = 1;
    this.#askSoon();
  }

  #askSoon(): void {
    clearTimeout(this.#asking);
    const waitMs = ASK_MS * (0.75 + 0.25 * (this.#options.random ?? Math.random)());
    this.#asking = setTimeout(() => void this.#ask(), waitMs);
  }

  /** Ask the service over HTTP: its first answer after none is the moment to try, whatever the wait still is. */
  async #ask(): Promise<void> {
    const isThere = await (this.#options.answers ?? serviceAnswers)();
    if (this.#isDone || this.#state.status !== 'lost') return;
    const isBack = isThere && this.#answers === 0;
    this.#answers = isThere ? this.#answers + 1 : 0;
    this.#say({ isBlocked: this.#mute >= BLOCKED_AFTER && this.#answers > BLOCKED_AFTER });
    this.#askSoon();
    if (!isBack) return;
    this.#attempt = 0;
    this.#mute = 0;
    this.#connect();
  }
}
