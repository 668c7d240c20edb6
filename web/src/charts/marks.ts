// Lines and bands of drawn charts, as paths.
import { area, line } from 'd3-shape';

type Value = number | null | undefined;
export type Values = readonly Value[];
type AtIndex = (index: number) => number;
type AtValue = (value: number) => number;

const isKnown = (value: Value): value is number => typeof value === 'number' && Number.isFinite(value);

/** A line through the known values; a gap stays a gap. */
export function lineOf(values: Values, x: AtIndex, y: AtValue): string {
  const drawn = line<Value>()
    .defined(isKnown)
    .x((_, index) => x(index))
    .y((value) => y(value ?? NaN))
    .digits(1);
  return drawn(values as Value[]) ?? '';
}

/** The area between two lines where both are known. */
export function bandOf(low: Values, high: Values, x: AtIndex, y: AtValue): string {
  const drawn = area<Value>()
    .defined((value, index) => isKnown(value) && isKnown(high[index]))
    .x((_, index) => x(index))
    .y0((value) => y(value ?? NaN))
    .y1((_, index) => y(high[index] ?? NaN))
    .digits(1);
  return drawn(low as Value[]) ?? '';
}

/** The beginning of a name that fits into so many pixels. */
export function fitted(name: string, room: number, letter = 7): string {
  const letters = Math.floor(room / letter);
  return name.length <= letters ? name : `${name.slice(0, Math.max(1, letters - 1))}…`;
}
