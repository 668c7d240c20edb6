// Reading the head of a CSV file, and guessing which columns belong to which sensor, so that a person only corrects.
import type { CsvColumn, CsvMapping, Placement } from '../api/types';

export type Delimiter = CsvMapping['delimiter'] & string;
export type Quantity = CsvColumn['quantity'];
export type Unit = CsvColumn['unit'];

export interface CsvHead {
  delimiter: Delimiter;
  columns: string[];
  rows: string[][];
}

/** Split one line; quoted fields may hold the delimiter, doubled quotes are one. */
export function splitLine(line: string, delimiter: string): string[] {
  const fields: string[] = [];
  let field = '';
  let isQuoted = false;
  for (let index = 0; index < line.length; index += 1) {
    const character = line.charAt(index);
    if (isQuoted) {
      if (character === '"' && line.charAt(index + 1) === '"') {
        field += '"';
        index += 1;
      } else if (character === '"') isQuoted = false;
      else field += character;
    } else if (character === '"') isQuoted = true;
    else if (character === delimiter) {
      fields.push(field.trim());
      field = '';
    } else field += character;
  }
  return [...fields, field.trim()];
}

/** First lines of a file: the delimiter that splits the header most, the names, a few rows. */
export function readHead(text: string, rows = 3): CsvHead {
  const lines = text.replace(/^\uFEFF/, '').split(/\r?\n/).filter((line) => line.trim() !== '');
  const header = lines[0] ?? '';
  const delimiters: Delimiter[] = [',', ';', '\t'];
  const delimiter = delimiters.reduce((best, one) => (splitLine(header, one).length > splitLine(header, best).length ? one : best));
  return { delimiter, columns: splitLine(header, delimiter), rows: lines.slice(1, 1 + rows).map((line) => splitLine(line, delimiter)) };
}

const QUANTITIES: { quantity: Quantity; words: RegExp; unit: Unit }[] = [
  { quantity: 'gyroscope', words: /gyr|omega|angular|ang_?vel/i, unit: 'rad/s' },
  { quantity: 'accelerometer', words: /acc|specific_?force/i, unit: 'm/s^2' },
  { quantity: 'magnetometer', words: /mag|field/i, unit: 'uT' },
];
const UNIT_WORDS: { words: RegExp; unit: Unit; of: Quantity }[] = [
  { words: /deg|dps/i, unit: 'deg/s', of: 'gyroscope' },
  { words: /(^|[^a-z])g($|[^a-z])/i, unit: 'g', of: 'accelerometer' },
  { words: /mT/, unit: 'mT', of: 'magnetometer' },
  { words: /gauss/i, unit: 'G', of: 'magnetometer' },
];
const TIME = /^(time|t|timestamp|seconds?)([^a-z]|$)/i;

/** A name without its axis, or null when it does not end in one. */
function withoutAxis(name: string): { stem: string; axis: 'x' | 'y' | 'z' } | null {
  const found = /^(.*?)[\s_.\-[(]*([xyzXYZ])[\s\])]*(?:[([{].*)?$/.exec(name);
  return found?.[2] ? { stem: (found[1] ?? '').toLowerCase(), axis: found[2].toLowerCase() as 'x' | 'y' | 'z' } : null;
}

function placementIn(stem: string, placements: readonly Placement[]): Placement | null {
  const plain = stem.replace(/[^a-z]+/gi, '_').toLowerCase();
  return (
    placements.find((placement) => plain.includes(placement)) ??
    placements.find((placement) => {
      const parts = placement.split('_');
      const side = parts.at(-1);
      if (side === 'left' || side === 'right') {
        const place = parts.slice(0, -1).join('_');
        return plain.includes(place) && (plain.includes(side) || plain.split('_').includes(side.charAt(0)));
      }
      return plain.includes(placement);
    }) ??
    null
  );
}

/** Triples of columns whose names tell quantity and axes, with placement where the name tells it too. */
export function guessSignals(columns: readonly string[], placements: readonly Placement[], fallback: Placement): CsvColumn[] {
  const groups = new Map<string, Partial<Record<'x' | 'y' | 'z', string>>>();
  for (const column of columns) {
    const parts = withoutAxis(column);
    if (!parts) continue;
    groups.set(parts.stem, { ...groups.get(parts.stem), [parts.axis]: column });
  }
  const found: CsvColumn[] = [];
  for (const [stem, { x, y, z }] of groups) {
    const kind = QUANTITIES.find((one) => one.words.test(stem));
    if (!kind || !x || !y || !z) continue;
    const unit = UNIT_WORDS.find((one) => one.of === kind.quantity && one.words.test(`${stem} ${x.slice(stem.length)}`))?.unit ?? kind.unit;
    found.push({ placement: placementIn(stem, placements) ?? fallback, quantity: kind.quantity, columns: [x, y, z], unit });
  }
  return found;
}

/** The column that looks like time. */
export function guessTime(columns: readonly string[]): string | null {
  return columns.find((column) => TIME.test(column)) ?? null;
}

/** What keeps a mapping from being sent, as keys of the catalogue. */
export function mappingProblems(mapping: CsvMapping): ('csv.needSignals' | 'csv.needGyroscope' | 'csv.needAccelerometer' | 'csv.twice' | 'csv.needTime' | 'csv.needColumns')[] {
  const problems = new Set<ReturnType<typeof mappingProblems>[number]>();
  if (mapping.signals.length === 0) problems.add('csv.needSignals');
  if (!mapping.time_column && !mapping.rate_hz) problems.add('csv.needTime');
  const seen = new Set<string>();
  for (const signal of mapping.signals) {
    const key = `${signal.placement}/${signal.quantity}`;
    if (seen.has(key)) problems.add('csv.twice');
    seen.add(key);
    if (signal.columns.some((column) => !column)) problems.add('csv.needColumns');
  }
  for (const placement of new Set(mapping.signals.map((one) => one.placement))) {
    if (!seen.has(`${placement}/gyroscope`)) problems.add('csv.needGyroscope');
    if (!seen.has(`${placement}/accelerometer`)) problems.add('csv.needAccelerometer');
  }
  return [...problems];
}
