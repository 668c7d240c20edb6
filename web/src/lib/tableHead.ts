// Where the table of a text file begins: what is no table, the delimiter, the names of the columns.
// `app/ingest/readers/_table_head.py` does the same; both are tested on tests/data/tables with the same answers.
import type { CsvMapping } from '../api/types';

export type Delimiter = NonNullable<CsvMapping['delimiter']>;

export interface TableHead {
  /** A blank stands for any number of blanks. */
  delimiter: Delimiter;
  /** Each name once: header lines joined, repeated names numbered, empty ones "column 3". */
  columns: string[];
  rows: string[][];
  skippedLines: number;
  /** Lines that are neither header nor data. */
  preamble: string[];
}

/** How much of a file is looked at. */
export const HEAD_BYTES = 256 * 1024;
const LINES = 200;
const MOST_HEADER_LINES = 3;
const DELIMITERS: readonly Delimiter[] = ['\t', ';', ',', ' '];
const COMMENT = /^\s*(\/\/|#|%)/;
const KEY_VALUE = /^\s*[A-Za-z][^,;\t":]*:([\s,;]|$)/;
const NUMBER = /^([+-]?(\d+([.,]\d+)?\.?|[.,]\d+)(e[+-]?\d+)?|nan|na|null|[+-]?inf)$/i;

interface Split {
  delimiter: Delimiter;
  fields: string[][];
  width: number;
  /** The first row of data among the lines with content. */
  first: number;
  numbers: number;
}

/** Split one line; quoted fields may hold the delimiter, doubled quotes are one. */
export function splitLine(line: string, delimiter: Delimiter): string[] {
  if (delimiter === ' ') return line.split(/\s+/).filter((field) => field !== '');
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

function splitAll(content: readonly string[], delimiter: Delimiter): Split {
  const fields = content.map((line) => splitLine(line, delimiter));
  const counted = new Map<number, number>();
  for (const one of fields) counted.set(one.length, (counted.get(one.length) ?? 0) + 1);
  const width = [...counted].reduce<[number, number]>((best, one) => (one[1] > best[1] || (one[1] === best[1] && one[0] > best[0]) ? one : best), [0, 0])[0];
  for (const [first, one] of fields.entries()) {
    const filled = one.filter((field) => field !== '');
    const numbers = filled.filter((field) => NUMBER.test(field)).length;
    if (width > 1 && one.length === width && 2 * numbers > filled.length) return { delimiter, fields, width, first, numbers };
  }
  return { delimiter, fields, width: fields[0]?.length ?? 0, first: Math.min(1, fields.length), numbers: 0 };
}

/** Which of the lines with content, straight above the data, name the columns. */
function headerLines(content: readonly string[], { fields, first, numbers, width }: Split): number[] {
  const found: number[] = [];
  for (let index = first - 1; index >= 0 && found.length < MOST_HEADER_LINES; index -= 1) {
    const count = fields[index]?.length;
    const isNames = count === width || (count === width - 1 && fields[first]?.at(-1) === '');
    if (numbers && (!isNames || KEY_VALUE.test(content[index] ?? ''))) break;
    found.unshift(index);
  }
  return found;
}

/** Join header lines column by column; a name above several columns holds until the next one. */
function joined(header: readonly string[][], width: number): string[] {
  const rows = header.map((fields, row) => {
    let last = '';
    return Array.from({ length: width }, (_, column) => {
      const field = fields[column] ?? '';
      last = field || last;
      return row < header.length - 1 ? last : field;
    });
  });
  return Array.from({ length: width }, (_, column) =>
    rows
      .map((fields) => fields[column])
      .filter(Boolean)
      .join(' '),
  );
}

/** Make each name stand once. */
function numbered(names: readonly string[]): string[] {
  const found = new Set<string>();
  names.forEach((name, position) => {
    const plain = name || `column ${position + 1}`;
    let unique = plain;
    for (let count = 2; found.has(unique); count += 1) unique = `${plain} (${count})`;
    found.add(unique);
  });
  return [...found];
}

/** Find the table in the first lines of a file. */
export function readHead(text: string, shownRows = 5): TableHead {
  const lines = text.replace(/^\uFEFF/, '').split('\n').map((line) => line.replace(/\r+$/, ''));
  const content = [...lines.keys()].filter((index) => lines[index]?.trim() && !COMMENT.test(lines[index])).slice(0, LINES);
  const texts = content.map((index) => lines[index] ?? '');
  const tried = DELIMITERS.map((delimiter) => splitAll(texts, delimiter));
  const most = (size: (one: Split) => number) => tried.reduce((best, one) => (size(one) > size(best) ? one : best));
  let best = most((one) => one.numbers);
  // No row of numbers: the first line is taken for the header, so that something can be shown.
  if (!best.numbers) best = most((one) => one.fields[0]?.length ?? 0);
  const { fields, first, width } = best;
  const header = headerLines(texts, best);
  const skippedLines = content[first] ?? (content.length ? (content.at(-1) ?? 0) + 1 : 0);
  const before = lines.slice(0, skippedLines);
  const comment = splitLine((before.findLast((line) => COMMENT.test(line)) ?? '').replace(COMMENT, '').trim(), best.delimiter);
  const names = header.length === 0 && comment.length === width ? comment : joined(header.map((index) => fields[index] ?? []), width);
  const used = new Set(header.map((index) => content[index]));
  return {
    delimiter: best.delimiter,
    columns: numbered(names),
    rows: fields.slice(first, first + shownRows),
    skippedLines,
    preamble: before.filter((line, index) => line.trim() && !used.has(index)),
  };
}

/** The head of a file that somebody chose. */
export async function headOf(file: File): Promise<TableHead> {
  const text = await file.slice(0, HEAD_BYTES).text();
  // The last line of a piece is cut off.
  return readHead(file.size > HEAD_BYTES ? text.slice(0, text.lastIndexOf('\n')) : text);
}
