// How far numbers lie apart.

/** Median and largest of what is known; null when nothing is. */
export function spreadOf(values: readonly (number | null)[]): { median: number; worst: number } | null {
  const known = values.filter((one): one is number => one !== null).sort((a, b) => a - b);
  if (!known.length) return null;
  return { median: known[Math.floor(known.length / 2)] ?? 0, worst: known[known.length - 1] ?? 0 };
}
