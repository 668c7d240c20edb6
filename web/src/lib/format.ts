// Numbers and dates as a therapist reads them. Degrees exist only here, at the edge of the screen.
import { formatLocale, t } from '../i18n';

/** How a unit of the service is shown: factor, sign, digits. */
export interface DisplayUnit {
  factor: number;
  suffix: string;
  digits: number;
}

const UNITS: Record<string, DisplayUnit> = {
  rad: { factor: 180 / Math.PI, suffix: '°', digits: 0 },
  deg: { factor: 1, suffix: '°', digits: 0 },
  'rad/s': { factor: 180 / Math.PI, suffix: ' °/s', digits: 0 },
  'deg/s': { factor: 1, suffix: ' °/s', digits: 0 },
  m: { factor: 100, suffix: ' cm', digits: 1 },
  metres: { factor: 1, suffix: ' m', digits: 0 },
  'm/s': { factor: 1, suffix: ' m/s', digits: 2 },
  s: { factor: 1, suffix: ' s', digits: 1 },
  ms: { factor: 1, suffix: ' ms', digits: 0 },
  '%': { factor: 1, suffix: ' %', digits: 0 },
  percent: { factor: 1, suffix: ' %', digits: 0 },
  '1': { factor: 1, suffix: '', digits: 2 },
  '': { factor: 1, suffix: '', digits: 2 },
  count: { factor: 1, suffix: '', digits: 0 },
};

/** Units that are words. */
const NAMED = { '1/m': 'unit.perMetre', bands: 'unit.tolerances' } as const;

/** How to show values of this unit; an unknown unit is shown as it is. */
export function displayUnit(unit: string | null | undefined): DisplayUnit {
  const name = unit ?? '';
  if (name === '1/m' || name === 'bands') return { factor: 1, suffix: ` ${t(NAMED[name])}`, digits: 1 };
  return UNITS[name] ?? { factor: 1, suffix: name ? ` ${name}` : '', digits: 2 };
}

/** The name of a curve on paper with the unit of its axis, e.g. `Height (cm)`; degrees stand at each number already. */
export function withUnit(name: string, unit: string | null | undefined): string {
  const suffix = displayUnit(unit).suffix.trim();
  return suffix === '' || suffix === '°' ? name : `${name} (${suffix})`;
}

/** A number at an axis, never without its unit. */
export function tick(value: number, unit: DisplayUnit): string {
  return `${plainTick(value, 2)}${unit.suffix}`;
}

/** A number at an axis that has its unit elsewhere: only the decimals that it needs. */
export function plainTick(value: number, digits: number): string {
  const text = new Intl.NumberFormat(formatLocale(), { maximumFractionDigits: digits, useGrouping: false }).format(
    Object.is(value, -0) ? 0 : value,
  );
  return /^-[0.,]+$/.test(text) ? text.slice(1) : text.replace('-', '−');
}

/** A plain number with a fixed count of decimals and a true minus sign. */
export function number(value: number | null | undefined, digits = 0): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  const text = new Intl.NumberFormat(formatLocale(), {
    minimumFractionDigits: digits,
    maximumFractionDigits: digits,
  }).format(value);
  return /^-[0.,]+$/.test(text) ? text.slice(1) : text.replace('-', '−');
}

/** A value in its display unit, e.g. `87°`. */
export function quantity(value: number | null | undefined, unit: string | null | undefined): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  const shown = displayUnit(unit);
  return `${number(value * shown.factor, shown.digits)}${shown.suffix}`;
}

/** A value in the unit that it is weighed by in a sum: a length by the metre, others as they are shown. */
export function weighedQuantity(value: number | null | undefined, unit: string | null | undefined): string {
  if (unit !== 'm' || value === null || value === undefined || !Number.isFinite(value)) return quantity(value, unit);
  return `${number(value, 3)} m`;
}

/**
 * How far two values lie apart: between percentages in percentage points, which are not a share of either. What is not
 * nothing gets the digit that shows it.
 */
export function span(value: number | null | undefined, unit: string | null | undefined): string {
  const { factor, digits, suffix } = displayUnit(unit);
  const size = Math.abs((value ?? NaN) * factor);
  const isTiny = size > 0 && size < 0.5 * 10 ** -digits;
  const text = isTiny ? `${number((value ?? NaN) * factor, digits + 1)}${suffix}` : quantity(value, unit);
  return displayUnit(unit).suffix === ' %' && text !== '–' ? t('unit.points', { number: text.slice(0, -2) }) : text;
}

/** A difference with its sign. */
export function difference(value: number, unit: string | null | undefined): string {
  return (value > 0 ? '+' : '') + span(value, unit);
}

/** A length of the body in cm, as a tape shows it: tenths only where they say something. */
export function bodyLength(metres: number | null | undefined): string {
  if (metres === null || metres === undefined || !Number.isFinite(metres)) return '–';
  const tenths = Math.round(metres * 1000);
  return `${number(tenths / 10, tenths % 10 === 0 ? 0 : 1)} cm`;
}

/**
 * A value and its uncertainty in the same digits, without a unit: `9.0` and `0.5`, never `9` and `0.5`. One rule for
 * pages and what is printed. Where the uncertainty would be shown as nothing, both have a digit more, and
 * where that is nothing too it is said to be below that digit. A spread of exactly 0 stays 0.
 */
export function pair(value: number, uncertainty: number, digits: number): [string, string] {
  return [number(value, digitsFor(uncertainty, digits)), spreadAlone(uncertainty, digits)];
}

/** An uncertainty that stands without its value, in the digits that it would have beside it. */
export function spreadAlone(uncertainty: number, digits: number): string {
  const size = Math.abs(uncertainty);
  const shown = digitsFor(size, digits);
  return isHidden(size, shown) ? `< ${number(10 ** -shown, shown)}` : number(size, shown);
}

/** The digits of a value with this uncertainty, and of what stands below it. */
export function digitsFor(uncertainty: number, digits: number): number {
  return isHidden(Math.abs(uncertainty), digits) ? digits + 1 : digits;
}

function isHidden(size: number, digits: number): boolean {
  return size > 0 && size < 0.5 * 10 ** -digits;
}

/** A value with its uncertainty, e.g. `87° ± 3` and `9.0° ± 0.5`; without one only the value. */
export function uncertain(value: number | null, uncertainty: number | null, unit: string): string {
  if (value === null || uncertainty === null || !Number.isFinite(uncertainty) || !Number.isFinite(value))
    return quantity(value, unit);
  const { factor, digits, suffix } = displayUnit(unit);
  const [text, size] = pair(value * factor, uncertainty * factor, digits);
  return `${text}${suffix} ± ${size}`;
}

const DAY_MS = 86_400_000;

function startOfDay(at: Date): number {
  return new Date(at.getFullYear(), at.getMonth(), at.getDate()).getTime();
}

/** Clock time, e.g. `14:05`. */
export function clockTime(at: string | Date): string {
  return new Intl.DateTimeFormat(formatLocale(), { hour: '2-digit', minute: '2-digit' }).format(new Date(at));
}

/** Clock time to the second of a moment in s since the epoch, e.g. `14:05:09`. */
export function clockTimeS(atS: number): string {
  return new Intl.DateTimeFormat(formatLocale(), { hour: '2-digit', minute: '2-digit', second: '2-digit' }).format(
    new Date(atS * 1000),
  );
}

const DATE_ONLY = /^(\d{4})-(\d{2})-(\d{2})$/;

/** A moment, or a day of the calendar (`1957-03-14`), which is the same day in every time zone. */
function dayOf(at: string | Date): Date {
  const only = typeof at === 'string' ? DATE_ONLY.exec(at) : null;
  return only ? new Date(Number(only[1]), Number(only[2]) - 1, Number(only[3])) : new Date(at);
}

/** Calendar date, e.g. `3 Mar 2025`; without the year when it is this year's. */
export function date(at: string | Date, now = new Date()): string {
  const day = dayOf(at);
  return new Intl.DateTimeFormat(formatLocale(), {
    day: 'numeric',
    month: 'short',
    ...(day.getFullYear() === now.getFullYear() ? {} : { year: 'numeric' }),
  }).format(day);
}

/** How long ago in words a person would use: today with the time, yesterday, days, then the date. */
export function day(at: string | Date | null, now = new Date()): string {
  if (at === null) return t('time.never');
  const then = dayOf(at);
  const days = Math.round((startOfDay(now) - startOfDay(then)) / DAY_MS);
  if (days === 0) return t('time.today', { time: clockTime(then) });
  if (days === 1) return t('time.yesterday', { time: clockTime(then) });
  if (days > 1 && days < 14) return t('time.daysAgo', { count: days });
  return date(then, now);
}

/** A day by its name, e.g. `Saturday 22 November`. */
export function weekday(at: string | Date): string {
  return new Intl.DateTimeFormat(formatLocale(), { weekday: 'long', day: 'numeric', month: 'long' }).format(dayOf(at));
}

/** Date and time, for lists where both count. */
export function dateTime(at: string | Date): string {
  return `${date(at)}, ${clockTime(at)}`;
}

/** Age in whole years. */
export function age(birthDate: string, now = new Date()): number {
  const born = dayOf(birthDate);
  const had =
    now.getMonth() > born.getMonth() || (now.getMonth() === born.getMonth() && now.getDate() >= born.getDate());
  return now.getFullYear() - born.getFullYear() - (had ? 0 : 1);
}

const plain = (value: number, digits: number) =>
  new Intl.NumberFormat(formatLocale(), {
    minimumFractionDigits: digits,
    maximumFractionDigits: digits,
    useGrouping: false,
  }).format(value);

/** Seconds as `1:05.2`, for positions on a time line. */
export function position(seconds: number, digits = 1): string {
  if (!Number.isFinite(seconds)) return '–';
  const scale = 10 ** digits;
  const whole = Math.round(Math.max(0, seconds) * scale);
  const minutes = Math.floor(whole / (60 * scale));
  const rest = (whole - minutes * 60 * scale) / scale;
  return `${minutes}:${plain(rest, digits).padStart(digits ? 3 + digits : 2, '0')}`;
}

/** Length of time in words, e.g. `4 min 10 s`. */
export function duration(seconds: number): string {
  if (!Number.isFinite(seconds)) return '–';
  const whole = Math.round(seconds);
  if (whole < 60) return t('time.seconds', { seconds: whole });
  const minutes = Math.floor(whole / 60);
  if (whole === minutes * 60) return t('time.wholeMinutes', { minutes });
  return t('time.minutes', { minutes, seconds: whole - minutes * 60 });
}

/** Sizes of files for people. */
export function bytes(size: number): string {
  if (size < 1e3) return `${number(size)} B`;
  if (size < 1e6) return `${number(size / 1e3)} kB`;
  if (size < 1e9) return `${number(size / 1e6, 1)} MB`;
  return `${number(size / 1e9, 2)} GB`;
}
