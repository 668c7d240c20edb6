// The page's side of the decoding worker; answers come in the order of the questions.
import { BlockError, decodeBlock, type Block } from './block';

export interface DecodeQuestion {
  id: number;
  buffer: ArrayBuffer;
}
export type DecodeAnswer = { id: number; block: Block } | { id: number; error: string };

export interface Decoder {
  decode(buffer: ArrayBuffer): Promise<Block>;
  close(): void;
}

interface Waiting {
  resolve: (block: Block) => void;
  reject: (error: Error) => void;
}

/** Decode in a worker of our own origin. */
export class WorkerDecoder implements Decoder {
  readonly #worker = new Worker(new URL('./decode.worker.ts', import.meta.url), { type: 'module' });
  readonly #waiting = new Map<number, Waiting>();
  #next = 0;

  constructor() {
    this.#worker.onmessage = (event: MessageEvent<DecodeAnswer>) => {
      const answer = event.data;
      const waiting = this.#waiting.get(answer.id);
      this.#waiting.delete(answer.id);
      if ('block' in answer) waiting?.resolve(answer.block);
      else waiting?.reject(new BlockError(answer.error));
    };
    this.#worker.onerror = () => this.#rejectAll('the decoding worker stopped; reload the page');
  }

  decode(buffer: ArrayBuffer): Promise<Block> {
    const id = this.#next;
    this.#next += 1;
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject });
      this.#worker.postMessage({ id, buffer } satisfies DecodeQuestion, [buffer]);
    });
  }

  close(): void {
    this.#worker.terminate();
    this.#rejectAll('closed');
  }

  #rejectAll(reason: string): void {
    for (const waiting of this.#waiting.values()) waiting.reject(new BlockError(reason));
    this.#waiting.clear();
  }
}

/** Decode on the spot, where there are no workers. */
export class InlineDecoder implements Decoder {
  decode(buffer: ArrayBuffer): Promise<Block> {
    return Promise.resolve().then(() => decodeBlock(buffer));
  }
  close(): void {}
}

export function createDecoder(): Decoder {
  return typeof Worker === 'undefined' ? new InlineDecoder() : new WorkerDecoder();
}
