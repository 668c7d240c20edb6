// The service's side of `/ws/ingest`, as docs/packet.md says it, for tests of the browser's gateway.

interface Received {
  sequence: number;
  isBackfilled: boolean;
  bytes: Uint8Array;
}

export class FakeService {
  /** Stored once, by sequence. */
  readonly stored = new Map<number, Received>();
  readonly hellos: Record<string, unknown>[] = [];
  readonly sockets: FakeIngestSocket[] = [];
  duplicates = 0;
  isReachable = true;
  /** Sequences that get lost on the way the first time. */
  drop = new Set<number>();
  goodbye: number | null = null;
  state = 'recording';
  /** What the next hello is answered with, and the connection closed. */
  refusal: object | null = null;

  create = (): WebSocket => {
    const socket = new FakeIngestSocket(this);
    this.sockets.push(socket);
    return socket as unknown as WebSocket;
  };

  ticket = (): Promise<string> =>
    this.isReachable ? Promise.resolve('ticket') : Promise.reject({ code: 'offline', reason: '' });

  breakLink(): void {
    this.isReachable = false;
    for (const socket of this.sockets) socket.cut();
  }

  get acknowledgement(): object {
    const highest = Math.max(-1, ...this.stored.keys());
    const missing: [number, number][] = [];
    for (let at = 0; at <= highest; at += 1) if (!this.stored.has(at)) missing.push([at, at + 1]);
    const acknowledged = missing[0] ? missing[0][0] - 1 : highest;
    if (this.goodbye !== null && acknowledged === this.goodbye) this.state = 'closing';
    return { type: 'acknowledge', session_id: 's', acknowledged, highest, missing, state: this.state };
  }

  acknowledge(): void {
    for (const socket of this.sockets) socket.say(this.acknowledgement);
  }
}

class FakeIngestSocket {
  readonly #service: FakeService;
  onopen: (() => void) | null = null;
  onmessage: ((event: { data: string }) => void) | null = null;
  onclose: ((event: { code: number }) => void) | null = null;
  binaryType = '';
  bufferedAmount = 0;
  #isOpen = false;

  constructor(service: FakeService) {
    this.#service = service;
    queueMicrotask(() => {
      if (!service.isReachable) return this.onclose?.({ code: 1006 });
      this.#isOpen = true;
      this.onopen?.();
    });
  }

  say(message: object): void {
    if (this.#isOpen) this.onmessage?.({ data: JSON.stringify(message) });
  }

  send(data: string | Uint8Array): void {
    if (!this.#isOpen) return;
    if (typeof data === 'string') {
      const message = JSON.parse(data) as Record<string, unknown>;
      if (message.type === 'goodbye') this.#service.goodbye = message.last_sequence as number;
      else {
        this.#service.hellos.push(message);
        this.say(this.#service.refusal ?? this.#service.acknowledgement);
      }
      return;
    }
    const sequence = new DataView(data.buffer, data.byteOffset).getUint32(12, true);
    if (this.#service.drop.delete(sequence)) return;
    if (this.#service.stored.has(sequence)) this.#service.duplicates += 1;
    else this.#service.stored.set(sequence, { sequence, isBackfilled: (data[9] ?? 0) === 2, bytes: data.slice() });
  }

  /** The link breaks, and what was sent last may be lost with it. */
  cut(): void {
    if (!this.#isOpen) return;
    this.#isOpen = false;
    this.onclose?.({ code: 1006 });
  }

  close(): void {
    this.#isOpen = false;
  }
}
