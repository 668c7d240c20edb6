import { describe, expect, it } from 'vitest';
import { decodeBlock } from '../../src/player/block';
import { FrameRing } from '../../src/player/ring';
import { columnsOf } from '../../src/player/types';
import { layoutMessage, packBlock } from './fixtures';

const ring = (seconds: number) => new FrameRing(columnsOf(layoutMessage()), seconds);
const block = (firstTick: number, ticks: number) =>
  decodeBlock(packBlock({ ticks, columns: 3, firstTick, value: (tick) => firstTick + tick }));

describe('FrameRing', () => {
  it('gives back what came, for the half-open interval', () => {
    const frames = ring(10);
    frames.push(block(0, 100));
    const { timeS, values } = frames.read(0.1, 0.2, ['elbow']);
    expect(timeS).toHaveLength(10);
    expect(timeS[0]).toBeCloseTo(0.1);
    expect(values[0]?.[9]).toBe(19);
  });

  it('never holds more than it has room for, and lets the oldest go', () => {
    const frames = ring(1);
    for (let start = 0; start < 1000; start += 7) frames.push(block(start, 7));
    expect(frames.count).toBe(100);
    const { timeS, values } = frames.read(-Infinity, Infinity, ['elbow']);
    expect(timeS).toHaveLength(100);
    expect([...(values[0] ?? [])]).toEqual([...timeS].map((time) => Math.round(time * 100)));
  });

  it('marks a gap with a break instead of a line across it', () => {
    const frames = ring(10);
    frames.push(block(0, 10));
    frames.push(block(50, 10));
    const { timeS, values } = frames.read(0, 1, ['elbow']);
    expect(timeS).toHaveLength(21);
    expect(values[0]?.[10]).toBeNaN();
    expect(timeS[10]).toBeGreaterThan(0.09);
    expect(timeS[10]).toBeLessThan(0.5);
  });

  it('leaves out what it has already, so time never runs back', () => {
    const frames = ring(10);
    frames.push(block(0, 20));
    frames.push(block(10, 20));
    const { timeS } = frames.read(0, 1, ['elbow']);
    expect(timeS).toHaveLength(30);
    for (let index = 1; index < timeS.length; index += 1)
      expect(timeS[index]).toBeGreaterThan(timeS[index - 1] ?? Infinity);
  });

  it('answers an unknown column with nothing', () => {
    const frames = ring(1);
    frames.push(block(0, 5));
    expect(frames.read(0, 1, ['no such column']).values[0]).toHaveLength(0);
  });
});
