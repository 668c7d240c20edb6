// The beginning of a large zip of tables: a small zip of the beginnings of its files, so that the service can look at each of them.
import { crc32 } from '../../sensors/gateway/crc32';

const END_BYTES = 22;
const LONGEST_COMMENT = 65_535;
const CENTRAL_BYTES = 46;
const LOCAL_BYTES = 30;
const MOST_DIRECTORY_BYTES = 1 << 20;
/** Of a member: encrypted, or a name in UTF-8. */
const KEPT_FLAGS = 0x801;
const ENCRYPTED = 0x1;
const STORED = 0;
const DEFLATED = 8;
const TABLE = /\.(csv|txt|tsv|dat|asc)$/i;
/** Of all tables together, unpacked; numbers pack to about a third of it. */
const UNPACKED_BYTES = 3 << 18;
/** What the service looks at of one table. */
const MOST_OF_ONE = 1 << 18;
const LEAST_OF_ONE = 1 << 10;

interface Member {
  name: Uint8Array<ArrayBuffer>;
  flags: number;
  method: number;
  packedBytes: number;
  at: number;
}

/** A small zip with the beginnings of the tables in a large one; null where it is none that can be looked into. */
export async function beginningsOf(zip: Blob, mostBytes: number): Promise<Blob | null> {
  const members = await membersOf(zip);
  if (!members) return null;
  const tables = members.filter(isTable).length;
  for (let each = Math.min(MOST_OF_ONE, UNPACKED_BYTES / Math.max(tables, 1)); each >= LEAST_OF_ONE; each /= 2) {
    const small = await packed(zip, members, Math.floor(each));
    if (small.size <= mostBytes) return small;
  }
  return null;
}

async function membersOf(zip: Blob): Promise<Member[] | null> {
  const tail = await viewOf(zip.slice(Math.max(0, zip.size - END_BYTES - LONGEST_COMMENT)));
  let end = tail.byteLength - END_BYTES;
  while (end >= 0 && tail.getUint32(end, true) !== 0x06054b50) end -= 1;
  if (end < 0) return null;
  const [length, first] = [tail.getUint32(end + 12, true), tail.getUint32(end + 16, true)];
  if (length > MOST_DIRECTORY_BYTES) return null;
  const directory = await viewOf(zip.slice(first, first + length));
  const found: Member[] = [];
  for (let at = 0; at + CENTRAL_BYTES <= directory.byteLength;) {
    if (directory.getUint32(at, true) !== 0x02014b50) return null;
    const sizes = [28, 30, 32].map((place) => directory.getUint16(at + place, true));
    const [named = 0, extra = 0, comment = 0] = sizes;
    if (at + CENTRAL_BYTES + named > directory.byteLength) return null;
    found.push({
      name: new Uint8Array(directory.buffer.slice(at + CENTRAL_BYTES, at + CENTRAL_BYTES + named)),
      flags: directory.getUint16(at + 8, true) & KEPT_FLAGS,
      method: directory.getUint16(at + 10, true),
      packedBytes: directory.getUint32(at + 20, true),
      at: directory.getUint32(at + 42, true),
    });
    at += CENTRAL_BYTES + named + extra + comment;
  }
  return found;
}

async function packed(zip: Blob, members: readonly Member[], each: number): Promise<Blob> {
  const files: BlobPart[] = [];
  const directory: BlobPart[] = [];
  let [at, listed] = [0, 0];
  for (const member of members) {
    const content = isTable(member) ? await startOf(zip, member, each) : new Uint8Array();
    const stored = content.length ? await through(new Blob([content]), new CompressionStream('deflate-raw')) : content;
    const method = content.length ? DEFLATED : isReadable(member) ? STORED : member.method;
    const local = header(0x04034b50, LOCAL_BYTES, 4, { ...member, method }, content, stored.length);
    const central = header(0x02014b50, CENTRAL_BYTES, 6, { ...member, method }, content, stored.length);
    central.setUint16(4, 20, true);
    central.setUint32(42, at, true);
    files.push(local, member.name, stored);
    directory.push(central, member.name);
    at += LOCAL_BYTES + member.name.length + stored.length;
    listed += CENTRAL_BYTES + member.name.length;
  }
  const end = new DataView(new ArrayBuffer(END_BYTES));
  end.setUint32(0, 0x06054b50, true);
  end.setUint16(8, members.length, true);
  end.setUint16(10, members.length, true);
  end.setUint32(12, listed, true);
  end.setUint32(16, at, true);
  return new Blob([...files, ...directory, end]);
}

/** What stands before a member, or of it in the list; both say the same from `place` on. */
function header(
  mark: number,
  bytes: number,
  place: number,
  member: Member,
  content: Uint8Array,
  packedBytes: number,
): DataView<ArrayBuffer> {
  const view = new DataView(new ArrayBuffer(bytes));
  view.setUint32(0, mark, true);
  view.setUint16(place, 20, true);
  view.setUint16(place + 2, member.flags, true);
  view.setUint16(place + 4, member.method, true);
  // The first day that a zip can name.
  view.setUint16(place + 8, 0x21, true);
  view.setUint32(place + 10, crc32(content), true);
  view.setUint32(place + 14, packedBytes, true);
  view.setUint32(place + 18, content.length, true);
  view.setUint16(place + 22, member.name.length, true);
  return view;
}

function isTable(member: Member): boolean {
  return isReadable(member) && TABLE.test(new TextDecoder().decode(member.name));
}

function isReadable(member: Member): boolean {
  return !(member.flags & ENCRYPTED) && (member.method === STORED || member.method === DEFLATED);
}

async function startOf(zip: Blob, member: Member, bytes: number): Promise<Uint8Array<ArrayBuffer>> {
  const local = await viewOf(zip.slice(member.at, member.at + LOCAL_BYTES));
  if (local.byteLength < LOCAL_BYTES) return new Uint8Array();
  const first = member.at + LOCAL_BYTES + local.getUint16(26, true) + local.getUint16(28, true);
  const content = zip.slice(first, first + member.packedBytes);
  if (member.method === STORED) return new Uint8Array((await viewOf(content.slice(0, bytes))).buffer);
  // A damaged member shows nothing here; the service refuses it when it comes as a whole.
  return through(content, new DecompressionStream('deflate-raw'), bytes).catch(() => new Uint8Array());
}

/** The first bytes of what comes out of a stream; no more of the blob is read than they need. */
async function through(
  blob: Blob,
  stream: CompressionStream | DecompressionStream,
  bytes = Infinity,
): Promise<Uint8Array<ArrayBuffer>> {
  const reader = blob.stream().pipeThrough<Uint8Array<ArrayBuffer>>(stream).getReader();
  const parts: Uint8Array<ArrayBuffer>[] = [];
  let count = 0;
  while (count < bytes) {
    const { value } = await reader.read();
    if (!value) break;
    parts.push(value);
    count += value.length;
  }
  // What is left need not be unpacked.
  void reader.cancel().catch(() => undefined);
  const whole = new Uint8Array(count);
  parts.reduce((at, part) => (whole.set(part, at), at + part.length), 0);
  return whole.slice(0, Math.min(count, bytes));
}

async function viewOf(blob: Blob): Promise<DataView<ArrayBuffer>> {
  return new DataView(await blob.arrayBuffer());
}
