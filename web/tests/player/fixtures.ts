import type { LayoutMessage } from '../../src/api/types';
import { PROTOCOL_VERSION } from '../../src/api/schema';

export const COLUMNS = ['elbow', 'elbow.sigma', 'elbow.flags'];

export function layoutMessage(change: Partial<LayoutMessage> = {}): LayoutMessage {
  return {
    type: 'layout',
    protocol_version: PROTOCOL_VERSION,
    session_id: 's',
    layout: { segments: [], points: [], angles: ['elbow'], scalars: [] },
    columns: COLUMNS,
    rate_hz: 100,
    ...change,
  };
}

/** A frame block as the service packs it; `value(tick, column)` fills the rows. */
export function packBlock(options: {
  ticks: number;
  columns: number;
  firstTick?: number;
  stepS?: number;
  startS?: number;
  publishedS?: number;
  value?: (tick: number, column: number) => number;
}): ArrayBuffer {
  const { ticks, columns, firstTick = 0, stepS = 0.01, publishedS = 1000 } = options;
  const buffer = new ArrayBuffer(40 + ticks * columns * 4);
  const view = new DataView(buffer);
  [...'TMF1'].forEach((letter, index) => view.setUint8(index, letter.charCodeAt(0)));
  view.setUint32(4, ticks, true);
  view.setUint32(8, columns, true);
  view.setUint32(12, firstTick, true);
  view.setFloat64(16, options.startS ?? firstTick * stepS, true);
  view.setFloat64(24, stepS, true);
  view.setFloat64(32, publishedS, true);
  for (let tick = 0; tick < ticks; tick += 1)
    for (let column = 0; column < columns; column += 1)
      view.setFloat32(40 + 4 * (tick * columns + column), options.value?.(tick, column) ?? tick + column / 10, true);
  return buffer;
}

/** A socket whose other side is the test. */
export class FakeSocket {
  static readonly made: FakeSocket[] = [];
  readonly sent: string[] = [];
  readyState = 0;
  binaryType = '';
  onopen: (() => void) | null = null;
  onmessage: ((event: { data: unknown }) => void) | null = null;
  onclose: ((event: { code: number; reason: string }) => void) | null = null;

  constructor(readonly url: string) {
    FakeSocket.made.push(this);
  }
  static create = (url: string) => new FakeSocket(url) as unknown as WebSocket;
  static get last(): FakeSocket {
    const socket = FakeSocket.made.at(-1);
    if (!socket) throw new Error('no socket was made');
    return socket;
  }
  accept(): void {
    this.readyState = 1;
    this.onopen?.();
  }
  say(message: object | ArrayBuffer): void {
    this.onmessage?.({ data: message instanceof ArrayBuffer ? message : JSON.stringify(message) });
  }
  drop(code = 1006, reason = ''): void {
    this.readyState = 3;
    this.onclose?.({ code, reason });
  }
  send(text: string): void {
    this.sent.push(text);
  }
  close(): void {
    this.readyState = 3;
  }
}

/** Let everything that was promised happen. */
export const settle = async () => {
  for (let turn = 0; turn < 12; turn += 1) await Promise.resolve();
};
