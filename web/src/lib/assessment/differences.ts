import type { Differences, Result } from '../../api/types';

export interface DifferenceRow {
  /** Name of the joint angle. */
  name: string;
  /** RMS against the reference in degrees, in the order of the other results; null where nothing could be compared. */
  rms: (number | null)[];
}

/** One row an angle, one column a result; the angle that differs most first. */
export function differenceRows(others: readonly (Differences | undefined)[]): DifferenceRow[] {
  const names = [...new Set(others.flatMap((one) => one?.angles.map((angle) => angle.name) ?? []))];
  const largest = (row: DifferenceRow) => Math.max(-1, ...row.rms.map((value) => value ?? -1));
  return names
    .map((name) => ({
      name,
      rms: others.map((one) => one?.angles.find((angle) => angle.name === name)?.rms_deg ?? null),
    }))
    .sort((a, b) => largest(b) - largest(a));
}

/** RMS over all angles that could be compared, weighted by the time compared. */
export function overallRms(one: Differences | undefined): number | null {
  const known = (one?.angles ?? []).filter((angle) => angle.rms_deg !== null && angle.compared_s > 0);
  const time = known.reduce((sum, angle) => sum + angle.compared_s, 0);
  return time > 0
    ? Math.sqrt(known.reduce((sum, angle) => sum + (angle.rms_deg ?? 0) ** 2 * angle.compared_s, 0) / time)
    : null;
}

/** The newest complete result of each estimator and kind: runs of the same thing would only repeat a column. */
export function distinctResults(results: readonly Result[], mainId: string | null): Result[] {
  const found = new Map<string, Result>();
  for (const one of results) {
    if (one.status !== 'complete') continue;
    const key = `${one.kind}/${one.orientation}/${one.orientation_version}/${JSON.stringify(one.orientation_parameters)}`;
    if (found.get(key)?.id !== mainId) found.set(key, one);
  }
  return [...found.values()];
}
