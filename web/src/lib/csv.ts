// Guessing which columns of a table belong to which sensor, so that a person only corrects. The rules are those of
// `app/ingest/readers/_csv_guess.py`, and in words docs/mappings.md: both are tested on tests/data/tables.
import type { CsvColumn, CsvMapping, Placement } from '../api/types';
import type { TableHead } from './tableHead';

export type Quantity = CsvColumn['quantity'];
export type Unit = CsvColumn['unit'];

/** A signal whose sensor is not known yet has no placement. */
export type DraftSignal = Omit<CsvColumn, 'placement'> & { placement: Placement | null };
export type CsvDraft = Omit<CsvMapping, 'signals'> & { signals: DraftSignal[] };

const QUANTITIES: { quantity: Quantity; words: RegExp; unit: Unit }[] = [
  { quantity: 'gyroscope', words: /gyr|omega|angular|ang_?vel/i, unit: 'rad/s' },
  { quantity: 'accelerometer', words: /acc|specific_?force/i, unit: 'm/s^2' },
  { quantity: 'magnetometer', words: /mag|field/i, unit: 'uT' },
];
const OTHER_UNITS: Partial<Record<Quantity, Record<string, Unit>>> = {
  accelerometer: { g: 'g' },
  magnetometer: { t: 'T', mt: 'mT', g: 'G', gauss: 'G' },
};
const UNIT_TAIL = /[\s_([{,]+(rad\/s|radps|deg\/s|degps|°\/s|dps|m\/s\^?2|m\/s²|m\/s\/s|mps2|gauss|g|[uµμ]?t|mt|s|ms|[uµμ]s)[\s)\]}]*$/i;
const AXIS = /^(.*?)[\s_.\-[(/]*([xyzXYZ])[\s\])]*(?:[([{].*)?$/;
/** As readHead numbers repeated names. */
const REPEATED = / \([0-9]+\)$/;
const TIME = /^(time|t|timestamp|seconds?)([^a-z]|$)/i;
const MILLI = /(^|[^a-z])(ms|milli[a-z]*)($|[^a-z])/i;
const MICRO = /(^|[^a-z])([uµμ]s|micro[a-z]*)($|[^a-z])/i;
const RATE = /(?:rate|frequency)[^0-9]{0,20}([0-9]+(?:\.[0-9]+)?)/i;
type Axis = 'x' | 'y' | 'z';

/** What is left of a name without its axis and unit, or null when it has no axis. */
function partsOf(column: string): { stem: string; axis: Axis } | null {
  const number = REPEATED.exec(column)?.[0] ?? '';
  const found = AXIS.exec(column.slice(0, column.length - number.length).replace(UNIT_TAIL, ''));
  return found?.[2] ? { stem: (found[1] ?? '').toLowerCase() + number, axis: found[2].toLowerCase() as Axis } : null;
}

function placementIn(stem: string, placements: readonly Placement[]): Placement | null {
  const plain = stem.toLowerCase().replace(/[^a-z]+/g, '_');
  return (
    placements.find((placement) => plain.includes(placement)) ??
    placements.find((placement) => {
      const at = placement.lastIndexOf('_');
      const side = placement.slice(at + 1);
      return at > 0 && plain.includes(placement.slice(0, at)) && (plain.includes(side) || plain.split('_').includes(side.charAt(0)));
    }) ??
    null
  );
}

function unitOf(column: string, { quantity, unit }: { quantity: Quantity; unit: Unit }): Unit {
  if (quantity === 'gyroscope') return /deg|dps|°/i.test(column) ? 'deg/s' : unit;
  return OTHER_UNITS[quantity]?.[(UNIT_TAIL.exec(column)?.[1] ?? '').toLowerCase()] ?? unit;
}

/** Triples of columns whose names tell quantity and axes, with placement where the name tells it too. */
export function guessSignals(columns: readonly string[], placements: readonly Placement[]): DraftSignal[] {
  const groups = new Map<string, Partial<Record<Axis, string>>>();
  for (const column of columns) {
    const parts = partsOf(column);
    if (parts) groups.set(parts.stem, { [parts.axis]: column, ...groups.get(parts.stem) });
  }
  const found: DraftSignal[] = [];
  for (const [stem, { x, y, z }] of groups) {
    const kind = QUANTITIES.find((one) => one.words.test(stem));
    if (kind && x && y && z) found.push({ placement: placementIn(stem, placements), quantity: kind.quantity, columns: [x, y, z], unit: unitOf(x, kind) });
  }
  return found;
}

/** The column that looks like time: by its name, and because a number stands in its first row. */
export function guessTime({ columns, rows }: Pick<TableHead, 'columns' | 'rows'>): string | null {
  return columns.find((column, index) => TIME.test(column) && /^[+\-.0-9]/.test(rows[0]?.[index] ?? '')) ?? null;
}

/** How to read the table, as far as its names and the lines above it tell. */
export function guessMapping(head: TableHead, placements: readonly Placement[]): CsvDraft {
  const time = guessTime(head);
  const rate = time ? null : RATE.exec(head.preamble.join('\n'));
  const unit = MICRO.test(time ?? '') ? 'us' : MILLI.test(time ?? '') ? 'ms' : 's';
  return { time_column: time, time_unit: unit, rate_hz: rate ? Number(rate[1]) : null, delimiter: head.delimiter, signals: guessSignals(head.columns, placements) };
}

/** What columns of one sensor have in common in their names: "left_sensor acc_x" and "left_sensor gyr_x" are of one. */
export function deviceOf(column: string): string {
  const stem = partsOf(column)?.stem ?? column;
  return stem.replace(/(gyr|omega|ang|vel|rate|acc|specific_?force|mag|field)[a-z]*/g, '').replace(/[^a-z0-9]+/g, ' ').trim();
}

/** What keeps a mapping from being sent, as keys of the catalogue. */
export function mappingProblems(mapping: CsvDraft): ('csv.needSignals' | 'csv.needPlacement' | 'csv.needGyroscope' | 'csv.needAccelerometer' | 'csv.twice' | 'csv.needTime' | 'csv.needColumns')[] {
  const problems = new Set<ReturnType<typeof mappingProblems>[number]>();
  if (mapping.signals.length === 0) problems.add('csv.needSignals');
  if (!mapping.time_column && !mapping.rate_hz) problems.add('csv.needTime');
  const seen = new Set<string>();
  for (const signal of mapping.signals) {
    if (!signal.placement) {
      problems.add('csv.needPlacement');
      continue;
    }
    const key = `${signal.placement}/${signal.quantity}`;
    if (seen.has(key)) problems.add('csv.twice');
    seen.add(key);
    if (signal.columns.some((column) => !column)) problems.add('csv.needColumns');
  }
  for (const placement of new Set(mapping.signals.flatMap((one) => one.placement ?? []))) {
    if (!seen.has(`${placement}/gyroscope`)) problems.add('csv.needGyroscope');
    if (!seen.has(`${placement}/accelerometer`)) problems.add('csv.needAccelerometer');
  }
  return [...problems];
}

/** The mapping to send; null while something is missing. */
export function complete(mapping: CsvDraft): CsvMapping | null {
  return mappingProblems(mapping).length === 0 ? (mapping as CsvMapping) : null;
}
