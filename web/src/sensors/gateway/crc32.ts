const TABLE = new Uint32Array(256).map((_, byte) => {
  let rest = byte;
  for (let bit = 0; bit < 8; bit += 1) rest = rest & 1 ? (rest >>> 1) ^ 0xedb88320 : rest >>> 1;
  return rest;
});

/** CRC-32 as in zlib; bytes for which `isSkipped` holds are not counted. */
export function crc32(bytes: Uint8Array, isSkipped?: (at: number) => boolean): number {
  let rest = 0xffffffff;
  for (let at = 0; at < bytes.length; at += 1) {
    if (isSkipped?.(at)) continue;
    rest = (TABLE[(rest ^ (bytes[at] ?? 0)) & 0xff] ?? 0) ^ (rest >>> 8);
  }
  return (rest ^ 0xffffffff) >>> 0;
}
