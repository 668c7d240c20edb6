import { Blob as NodeBlob } from 'node:buffer';
import { deflateRawSync, inflateRawSync } from 'node:zlib';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { crc32 } from '../../../src/sensors/gateway/crc32';
import { BEGINNING_BYTES, beginningOf, laterOf } from '../../../src/pages/upload/beginning';
import { beginningsOf } from '../../../src/pages/upload/zipped';

const blobOf = (bytes: Uint8Array) => new NodeBlob([bytes]) as unknown as Blob;

interface Packed {
  name: string;
  content: string;
  method?: number;
  flags?: number;
}

/** A zip as packers write it: with a data descriptor left out, an extra field and a comment. */
function zipOf(members: readonly Packed[], comment = 'packed on a phone'): Uint8Array {
  const parts: Buffer[] = [];
  const directory: Buffer[] = [];
  let at = 0;
  for (const { name, content, method = 8, flags = 0 } of members) {
    const [bytes, title] = [Buffer.from(content), Buffer.from(name)];
    const stored = method === 8 ? deflateRawSync(bytes) : bytes;
    const shared = Buffer.alloc(26);
    shared.writeUInt16LE(20, 0);
    shared.writeUInt16LE(flags, 2);
    shared.writeUInt16LE(method, 4);
    shared.writeUInt32LE(crc32(bytes), 10);
    shared.writeUInt32LE(stored.length, 14);
    shared.writeUInt32LE(bytes.length, 18);
    shared.writeUInt16LE(title.length, 22);
    shared.writeUInt16LE(4, 24);
    const extra = Buffer.from([1, 0, 0, 0]);
    const local = Buffer.concat([Buffer.from('PK\x03\x04', 'latin1'), shared, title, extra, stored]);
    const rest = Buffer.alloc(14);
    rest.writeUInt32LE(at, 10);
    directory.push(Buffer.concat([Buffer.from('PK\x01\x02\x14\x00', 'latin1'), shared, rest, title, extra]));
    parts.push(local);
    at += local.length;
  }
  const listed = Buffer.concat(directory);
  const end = Buffer.alloc(22);
  end.write('PK\x05\x06', 'latin1');
  end.writeUInt16LE(members.length, 8);
  end.writeUInt16LE(members.length, 10);
  end.writeUInt32LE(listed.length, 12);
  end.writeUInt32LE(at, 16);
  end.writeUInt16LE(comment.length, 20);
  return Buffer.concat([...parts, listed, end, Buffer.from(comment)]);
}

/** Names and contents of a zip, by its list. */
async function membersOf(blob: Blob): Promise<Record<string, string>> {
  const bytes = Buffer.from(await blob.arrayBuffer());
  const end = bytes.lastIndexOf('PK\x05\x06', undefined, 'latin1');
  const found: Record<string, string> = {};
  for (let at = bytes.readUInt32LE(end + 16); at < end; at += 46 + bytes.readUInt16LE(at + 28)) {
    const first = bytes.readUInt32LE(at + 42);
    const data = bytes.subarray(first + 30 + bytes.readUInt16LE(first + 26));
    const packed = data.subarray(0, bytes.readUInt32LE(at + 20));
    const content = bytes.readUInt16LE(at + 10) === 8 ? inflateRawSync(packed) : packed;
    expect(content.length).toBe(bytes.readUInt32LE(at + 24));
    expect(crc32(content)).toBe(bytes.readUInt32LE(at + 16));
    found[bytes.toString('utf8', at + 46, at + 46 + bytes.readUInt16LE(at + 28))] = content.toString();
  }
  return found;
}

function table(rows: number, seed: number): string {
  const lines = ['Time (s),x,y,z'];
  for (let k = 0; k < rows; k += 1) {
    lines.push([k / 100, ...[1, 2, 3].map((axis) => Math.sin(seed * k * axis * 1e6))].join(','));
  }
  return lines.join('\n');
}

describe('the beginning of a file', () => {
  it('is sent in base64, and no more of it than is looked at', async () => {
    expect(await beginningOf(new Blob(['t,x\n']))).toBe(btoa('t,x\n'));
    const sent = await beginningOf(new Blob([new Uint8Array(BEGINNING_BYTES + 10).fill(255)]));
    expect(atob(sent)).toHaveLength(BEGINNING_BYTES);
  });

  it('goes with pieces of the rest up to its end, but of a zip', async () => {
    const bytes = new Uint8Array(3_000_000).map((_, k) => k >> 16);
    expect(await laterOf(new Blob([bytes.subarray(0, BEGINNING_BYTES)]))).toEqual([]);
    expect((await laterOf(new Blob([bytes.subarray(0, BEGINNING_BYTES + 9)]))).length).toBe(1);
    const later = await laterOf(new Blob([bytes]));
    expect(later).toHaveLength(12);
    expect(new Set(later.map((one) => atob(one).charCodeAt(0))).size).toBe(12);
    expect(atob(later[11] ?? '')).toHaveLength(32 * 1024);
    expect(atob(later[11] ?? '').charCodeAt(32 * 1024 - 1)).toBe(bytes[2_999_999]);
    bytes.set([0x50, 0x4b, 3, 4]);
    expect(await laterOf(new Blob([bytes]))).toEqual([]);
  });
});

describe('the beginning of a large zip', () => {
  // The blobs of jsdom have no streams.
  beforeEach(() => vi.stubGlobal('Blob', NodeBlob));
  afterEach(() => vi.unstubAllGlobals());

  const members: Packed[] = [
    { name: 'walk/Gyroscope.csv', content: table(20_000, 1) },
    { name: 'walk/Accelerometer.csv', content: table(20_000, 2), method: 0 },
    { name: 'walk/meta/time.csv', content: 'event,experiment time\nSTART,0\n' },
    { name: 'walk/photo.jpg', content: 'x'.repeat(50_000) },
    { name: 'walk/größe.txt', content: 'cm\n', flags: 0x800 },
  ];

  it('is a small zip with the beginning of each table, and the names of all files', async () => {
    const small = await beginningsOf(blobOf(zipOf(members)), BEGINNING_BYTES);
    expect(small?.size).toBeLessThanOrEqual(BEGINNING_BYTES);
    const found = await membersOf(small as Blob);
    expect(Object.keys(found)).toEqual(members.map((one) => one.name));
    for (const { name, content } of members) {
      expect(content.startsWith(found[name] ?? '?')).toBe(true);
    }
    // Ten seconds at 100 Hz at least.
    expect(found['walk/Gyroscope.csv']?.split('\n').length).toBeGreaterThan(1001);
    expect(found['walk/Accelerometer.csv']?.split('\n').length).toBeGreaterThan(1001);
    expect(found['walk/meta/time.csv']).toBe(members[2]?.content);
    expect(found['walk/photo.jpg']).toBe('');
  });

  it('has room for many tables', async () => {
    const many = Array.from({ length: 60 }, (_, k) => ({ name: `${String(k)}.csv`, content: table(800, k + 1) }));
    const small = await beginningsOf(blobOf(zipOf(many)), BEGINNING_BYTES);
    expect(small?.size).toBeLessThanOrEqual(BEGINNING_BYTES);
    const found = await membersOf(small as Blob);
    expect(Object.values(found).every((one) => one.split('\n').length > 50)).toBe(true);
  });

  it('says of a locked file that it is locked, and nothing of what is no zip', async () => {
    const locked = zipOf([{ name: 'a.csv', content: table(9000, 1), flags: 1 }]);
    const bytes = Buffer.from(await ((await beginningsOf(blobOf(locked), BEGINNING_BYTES)) as Blob).arrayBuffer());
    expect(bytes.readUInt16LE(6) & 1).toBe(1);
    expect(await beginningsOf(blobOf(zipOf(members).subarray(0, 300_000)), BEGINNING_BYTES)).toBeNull();
  });
});
