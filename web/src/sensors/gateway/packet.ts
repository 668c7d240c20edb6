// The body-network packet, version 1: values to the bytes that a gateway sends (docs/packet.md has its table and vectors).
import { crc32 } from './crc32';

export const GYROSCOPE = 1;
export const ACCELEROMETER = 2;
export const MAGNETOMETER = 4;
/** Gyroscope and accelerometer, three values each: what a sensor in the browser gives. */
export const MOTION = GYROSCOPE | ACCELEROMETER;
export const MOTION_VALUES = 6;

const HEADER_BYTES = 32;
const FLAGS_AT = 9;
const SEQUENCE_AT = 12;
const CRC_AT = 28;
const BACKFILLED = 2;

export interface PacketFields {
  sequence: number;
  /** Device clock at the first tick, whole microseconds. */
  deviceTimeUs: bigint;
  tickIntervalUs: number;
  sensors: number;
  ticks: number;
  /** Channel mask; bits 0 to 2. */
  channels: number;
  /** By tick, then sensor, then channel: rad/s, m/s², T as floats, or counts. */
  values: Float32Array | Int16Array;
  isBackfilled?: boolean;
}

/** CRC-32 as in zlib, of header bytes 0 to 27 and the payload. */
function checksum(bytes: Uint8Array): number {
  return crc32(bytes, (at) => at >= CRC_AT && at < HEADER_BYTES);
}

/** The bytes of one packet. */
export function encodePacket(fields: PacketFields): Uint8Array<ArrayBuffer> {
  const { values } = fields;
  const isCounts = values instanceof Int16Array;
  const bytes = new Uint8Array(HEADER_BYTES + values.byteLength);
  const view = new DataView(bytes.buffer);
  bytes.set([0x42, 0x4e, 0x50, 0x31, fields.sensors, fields.ticks]);
  view.setUint16(6, fields.channels, true);
  view.setUint8(8, isCounts ? 1 : 0);
  view.setUint8(FLAGS_AT, fields.isBackfilled ? BACKFILLED : 0);
  view.setUint32(SEQUENCE_AT, fields.sequence, true);
  view.setBigUint64(16, fields.deviceTimeUs, true);
  view.setUint32(24, fields.tickIntervalUs, true);
  values.forEach((value, at) => {
    if (isCounts) view.setInt16(HEADER_BYTES + 2 * at, value, true);
    else view.setFloat32(HEADER_BYTES + 4 * at, value, true);
  });
  view.setUint32(CRC_AT, checksum(bytes), true);
  return bytes;
}

/** The same packet, marked as sent after a broken link. */
export function backfilled(packet: Uint8Array): Uint8Array {
  const bytes = packet.slice();
  const view = new DataView(bytes.buffer);
  view.setUint8(FLAGS_AT, view.getUint8(FLAGS_AT) | BACKFILLED);
  view.setUint32(CRC_AT, checksum(bytes), true);
  return bytes;
}
