// The binary frame block of `app.live.messages`, decoded to one array a column.

const MAGIC = 0x31464d54; // `TMF1`, little endian
const HEADER_BYTES = 40;

/** Frames of consecutive ticks; `columns[c][k]` is column c at tick k. */
export interface Block {
  firstTick: number;
  startS: number;
  stepS: number;
  /** Server time of publication, seconds since the epoch. */
  publishedS: number;
  ticks: number;
  columns: Float32Array[];
}

/** The bytes are not a frame block as both sides agreed on. */
export class BlockError extends Error {
  override readonly name = 'BlockError';
}

/** Decode a block; throws `BlockError` when length and header do not agree. */
export function decodeBlock(buffer: ArrayBuffer): Block {
  if (buffer.byteLength < HEADER_BYTES)
    throw new BlockError(`block of ${buffer.byteLength} bytes is shorter than its header`);
  const view = new DataView(buffer);
  if (view.getUint32(0, true) !== MAGIC) throw new BlockError('block does not begin with TMF1');
  const ticks = view.getUint32(4, true);
  const count = view.getUint32(8, true);
  const expected = HEADER_BYTES + ticks * count * 4;
  if (buffer.byteLength !== expected) {
    throw new BlockError(
      `block of ${ticks} ticks and ${count} columns must have ${expected} bytes, not ${buffer.byteLength}`,
    );
  }
  const rows = new Float32Array(buffer, HEADER_BYTES, ticks * count);
  const columns: Float32Array[] = [];
  for (let column = 0; column < count; column += 1) {
    const values = new Float32Array(ticks);
    for (let tick = 0; tick < ticks; tick += 1) values[tick] = rows[tick * count + column] ?? NaN;
    columns.push(values);
  }
  return {
    firstTick: view.getUint32(12, true),
    startS: view.getFloat64(16, true),
    stepS: view.getFloat64(24, true),
    publishedS: view.getFloat64(32, true),
    ticks,
    columns,
  };
}
