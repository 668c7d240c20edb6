import { describe, expect, it } from 'vitest';
import { BlockError, decodeBlock } from '../../src/player/block';
import { packBlock } from './fixtures';

describe('decodeBlock', () => {
  it('turns rows into columns and reads the header', () => {
    const block = decodeBlock(
      packBlock({
        ticks: 3,
        columns: 2,
        firstTick: 500,
        stepS: 0.01,
        publishedS: 1234.5,
        value: (tick, column) => tick * 10 + column,
      }),
    );
    expect(block.ticks).toBe(3);
    expect(block.firstTick).toBe(500);
    expect(block.startS).toBeCloseTo(5);
    expect(block.stepS).toBe(0.01);
    expect(block.publishedS).toBe(1234.5);
    expect([...(block.columns[0] ?? [])]).toEqual([0, 10, 20]);
    expect([...(block.columns[1] ?? [])]).toEqual([1, 11, 21]);
  });

  it('keeps what was not measured as NaN', () => {
    const block = decodeBlock(packBlock({ ticks: 1, columns: 1, value: () => NaN }));
    expect(block.columns[0]?.[0]).toBeNaN();
  });

  it('accepts a block without ticks', () => {
    expect(decodeBlock(packBlock({ ticks: 0, columns: 5 })).columns).toHaveLength(5);
  });

  it.each([
    ['shorter than a header', new ArrayBuffer(12)],
    [
      'another magic',
      (() => {
        const bytes = packBlock({ ticks: 1, columns: 1 });
        new DataView(bytes).setUint8(0, 88);
        return bytes;
      })(),
    ],
    ['cut short', packBlock({ ticks: 2, columns: 2 }).slice(0, -4)],
    [
      'too long',
      (() => {
        const bytes = new Uint8Array(48);
        bytes.set(new Uint8Array(packBlock({ ticks: 1, columns: 1 })));
        return bytes.buffer;
      })(),
    ],
  ])('refuses a block that is %s', (_, bytes) => {
    expect(() => decodeBlock(bytes)).toThrow(BlockError);
  });
});
