import { crc32 } from 'node:zlib';
import { readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import {
  ACCELEROMETER,
  backfilled,
  encodePacket,
  GYROSCOPE,
  MAGNETOMETER,
  MOTION,
} from '../../src/sensors/gateway/packet';

const hex = (bytes: Uint8Array) => Buffer.from(bytes).toString('hex');
/** The vectors as the page for gateways prints them. */
const vectors = [...readFileSync('../docs/packet.md', 'utf8').matchAll(/(?:^ {4}[0-9a-f]+\n)+/gm)].map(([lines]) =>
  lines.replace(/\s/g, ''),
);

describe('the packet of the wire format', () => {
  it('is the first vector of its page: counts of two sensors', () => {
    const values = Int16Array.from([100, -200, 300, 4, 5, 1000, 1, 2, 3, -4, -5, -1000]);
    const packet = encodePacket({
      sequence: 7,
      deviceTimeUs: 1_000_000_000n,
      tickIntervalUs: 10_000,
      sensors: 2,
      ticks: 1,
      channels: MOTION,
      values,
    });
    expect(hex(packet)).toBe(vectors[0]);
  });

  it('is the second: nine axes as floats, back-filled, with the highest sequence and time', () => {
    const tick = [0.5, -0.25, 0.125, 0, 0, 9.75, 2e-5, 0, -4.5e-5];
    const fields = {
      sequence: 4_294_967_295,
      deviceTimeUs: 18_446_744_073_709_551_000n,
      tickIntervalUs: 16_667,
      sensors: 1,
      ticks: 2,
      channels: GYROSCOPE | ACCELEROMETER | MAGNETOMETER,
      values: Float32Array.from([...tick, ...tick]),
    };
    expect(hex(encodePacket({ ...fields, isBackfilled: true }))).toBe(vectors[1]);
    expect(hex(backfilled(encodePacket(fields)))).toBe(vectors[1]);
  });

  it('carries the checksum that zlib gives', () => {
    const values = Float32Array.from({ length: 36 }, (_, at) => Math.sin(at));
    const packet = encodePacket({
      sequence: 1,
      deviceTimeUs: 5n,
      tickIntervalUs: 16_667,
      sensors: 1,
      ticks: 6,
      channels: MOTION,
      values,
    });
    const covered = Buffer.concat([packet.subarray(0, 28), packet.subarray(32)]);
    expect(new DataView(packet.buffer).getUint32(28, true)).toBe(crc32(covered));
  });
});
