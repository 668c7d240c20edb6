// The mapping of a table as the service guessed it (`/api/uploads/preview`), until a person has corrected and completed it.
import type { CsvMapping, GuessedColumn, GuessedMapping, Placement, TablePreview } from '../api/types';

export type Quantity = GuessedColumn['quantity'];
export type Unit = NonNullable<GuessedColumn['unit']>;
export type Pipeline = TablePreview['pipeline'];

/** What tells the signals of one sensor from those of another. */
export function sensorOf(signal: GuessedColumn): string {
  return signal.placement ?? signal.sensor ?? '';
}

/** A column of a mapping without its sign: `-acc_z` is `acc_z` turned, unless a column is called so. */
export function signedColumn(value: string, columns: readonly string[]): { column: string; isTurned: boolean } {
  const isTurned = value.startsWith('-') && !columns.includes(value);
  return { column: isTurned ? value.slice(1) : value, isTurned };
}

/** A placement is chosen once for all signals of a sensor. */
export function placed(mapping: GuessedMapping, chosen: GuessedColumn, placement: Placement | null): GuessedMapping {
  const isSame = (one: GuessedColumn) =>
    one === chosen || (one.placement === chosen.placement && (one.sensor ?? '') === (chosen.sensor ?? ''));
  return { ...mapping, signals: mapping.signals.map((one) => (isSame(one) ? { ...one, placement } : one)) };
}

/** What keeps a mapping from being sent, as keys of the catalogue. Sensors on no body need no placement. */
export function mappingProblems(
  mapping: GuessedMapping,
  hasPlaces: boolean,
): (
  | 'csv.needSignals'
  | 'csv.needPlacement'
  | 'csv.needGyroscope'
  | 'csv.needAccelerometer'
  | 'csv.twice'
  | 'csv.needTime'
  | 'csv.needColumns'
  | 'csv.needUnit'
)[] {
  const problems = new Set<ReturnType<typeof mappingProblems>[number]>();
  if (mapping.signals.length === 0) problems.add('csv.needSignals');
  if ((!mapping.time_column || mapping.time_unit === 'count') && !mapping.rate_hz) problems.add('csv.needTime');
  const seen = new Set<string>();
  for (const signal of mapping.signals) {
    if (!signal.placement && hasPlaces) {
      problems.add('csv.needPlacement');
      continue;
    }
    const key = `${sensorOf(signal)}/${signal.quantity}`;
    if (seen.has(key)) problems.add('csv.twice');
    seen.add(key);
    if (signal.columns.some((column) => !column || column === '-')) problems.add('csv.needColumns');
    if (!signal.unit) problems.add('csv.needUnit');
  }
  for (const sensor of new Set([...seen].map((key) => key.slice(0, key.lastIndexOf('/'))))) {
    if (!seen.has(`${sensor}/gyroscope`)) problems.add('csv.needGyroscope');
    if (!seen.has(`${sensor}/accelerometer`)) problems.add('csv.needAccelerometer');
  }
  return [...problems];
}

/** The mapping to send; null while something is missing. */
export function complete(mapping: GuessedMapping, hasPlaces: boolean): CsvMapping | null {
  return mappingProblems(mapping, hasPlaces).length === 0 ? (mapping as CsvMapping) : null;
}
