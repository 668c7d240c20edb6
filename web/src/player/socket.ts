// A WebSocket that comes back: waits longer after each failure, with a little chance so that a thousand
// browsers do not return at once, and stops when the service said no.

export type SocketStatus = 'connecting' | 'open' | 'lost' | 'refused' | 'closed';

export interface ReturningSocketOptions {
  url: string;
  onText?: (text: string) => void;
  onBinary?: (buffer: ArrayBuffer) => void;
  onOpen?: () => void;
  onStatus: (status: SocketStatus, reason: string) => void;
  random?: () => number;
  create?: (url: string) => WebSocket;
}

const FIRST_DELAY_MS = 500;
const LONGEST_DELAY_MS = 15_000;
/** A try that is not answered for so long will not be: the network was away when it began. */
const OPEN_TIMEOUT_MS = 6000;
/** Close codes after which another try cannot help: policy, and the service's own refusals. */
const isRefusal = (code: number) => code === 1008 || code === 1003 || (code >= 4400 && code < 4500);

/** Wait before the given try (0 is the first after a loss): doubles up to 15 s, a quarter of it by chance. */
export function backOffMs(attempt: number, random: () => number = Math.random): number {
  const base = Math.min(LONGEST_DELAY_MS, FIRST_DELAY_MS * 2 ** attempt);
  return base * (0.75 + 0.25 * random());
}

export class ReturningSocket {
  readonly #options: ReturningSocketOptions;
  #socket: WebSocket | null = null;
  #attempt = 0;
  #timer: ReturnType<typeof setTimeout> | undefined;
  #wasOpen = false;
  #isDone = false;

  constructor(options: ReturningSocketOptions) {
    this.#options = options;
    this.#connect();
  }

  get isOpen(): boolean {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  send(message: object): void {
    if (this.isOpen) this.#socket?.send(JSON.stringify(message));
  }

  /** Stop for good because the two sides cannot understand each other. */
  refuse(reason: string): void {
    if (this.#isDone) return;
    this.#finish();
    this.#options.onStatus('refused', reason);
  }

  close(): void {
    if (this.#isDone) return;
    this.#finish();
    this.#options.onStatus('closed', '');
  }

  /** Let go of a socket that is open and says nothing, and open another. */
  reopen(): void {
    if (this.#isDone) return;
    this.#drop();
    this.#connect();
  }

  #finish(): void {
    this.#isDone = true;
    clearTimeout(this.#timer);
    this.#socket?.close();
  }

  /** Forget the present socket: it takes long to close where nobody answers. */
  #drop(): void {
    clearTimeout(this.#timer);
    const socket = this.#socket;
    if (!socket) return;
    socket.onopen = socket.onmessage = socket.onclose = null;
    socket.close();
  }

  #connect(): void {
    const socket = (this.#options.create ?? ((url) => new WebSocket(url)))(this.#options.url);
    this.#socket = socket;
    socket.binaryType = 'arraybuffer';
    if (!this.#wasOpen) this.#options.onStatus('connecting', '');
    this.#timer = setTimeout(() => {
      this.#drop();
      this.#lost('');
    }, OPEN_TIMEOUT_MS);
    socket.onopen = () => {
      clearTimeout(this.#timer);
      this.#attempt = 0;
      this.#wasOpen = true;
      this.#options.onStatus('open', '');
      this.#options.onOpen?.();
    };
    socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => {
      if (this.#isDone) return;
      if (typeof event.data === 'string') this.#options.onText?.(event.data);
      else this.#options.onBinary?.(event.data);
    };
    socket.onclose = (event) => {
      if (this.#isDone) return;
      clearTimeout(this.#timer);
      if (isRefusal(event.code)) {
        this.#finish();
        this.#options.onStatus('refused', event.reason);
        return;
      }
      this.#lost(event.reason);
    };
  }

  #lost(reason: string): void {
    this.#options.onStatus('lost', reason);
    const delay = backOffMs(this.#attempt, this.#options.random);
    this.#attempt += 1;
    this.#timer = setTimeout(() => this.#connect(), delay);
  }
}
