// Decodes frame blocks beside the page, so that drawing never waits for arithmetic.
import { decodeBlock } from './block';
import type { DecodeAnswer, DecodeQuestion } from './decoder';

self.onmessage = (event: MessageEvent<DecodeQuestion>) => {
  const { id, buffer } = event.data;
  let answer: DecodeAnswer;
  let owned: ArrayBuffer[] = [];
  try {
    const block = decodeBlock(buffer);
    owned = block.columns.map((column) => column.buffer as ArrayBuffer);
    answer = { id, block };
  } catch (error) {
    answer = { id, error: error instanceof Error ? error.message : String(error) };
  }
  self.postMessage(answer, { transfer: owned });
};
