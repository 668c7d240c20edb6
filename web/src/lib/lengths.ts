// A length of the body as somebody types it: in metres or centimetres, with a point or a comma.

/** The length in cm; null for nothing typed, NaN for what is no length. */
export function readLengthCm(text: string): number | null {
  const typed = text.trim().toLowerCase().replace(',', '.');
  if (typed === '') return null;
  const found = /^(\d+(?:\.\d+)?|\.\d+)\s*(m|cm)?$/.exec(typed);
  if (!found) return NaN;
  const value = Number(found[1]);
  // Nothing measured here is shorter than 5 cm or longer than 3 m: a bare number says by itself which it is.
  const isMetres = found[2] === 'm' || (found[2] === undefined && value < 3);
  return Math.round((isMetres ? value * 100 : value) * 10) / 10;
}
