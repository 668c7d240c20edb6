// A day as somebody types it. Days come first, as in the clinic; the browser's own field would show another order.
import { formatLocale, t } from '../i18n';

const MONTHS = ['jan', 'feb', 'mar', 'apr', 'may', 'jun', 'jul', 'aug', 'sep', 'oct', 'nov', 'dec'];
/** Where a German month begins otherwise. */
const GERMAN: Record<string, string | undefined> = { mär: 'mar', mrz: 'mar', mai: 'may', okt: 'oct', dez: 'dec' };

/** The day as `2025-03-31`; empty for nothing typed, null for what is no day. */
export function readDay(text: string): string | null {
  const typed = text.trim().toLowerCase();
  if (typed === '') return '';
  const iso = /^(\d{4})-(\d{1,2})-(\d{1,2})$/.exec(typed);
  const numbers = /^(\d{1,2})[./ -](\d{1,2})[./ -](\d{4})$/.exec(typed);
  const words = /^(\d{1,2})\.?[ -]([a-zä]{3})[a-zä]*\.?,?[ -](\d{4})$/.exec(typed);
  const [year, month, day] = iso
    ? [Number(iso[1]), Number(iso[2]), Number(iso[3])]
    : numbers
      ? [Number(numbers[3]), Number(numbers[2]), Number(numbers[1])]
      : words
        ? [Number(words[3]), MONTHS.indexOf(GERMAN[words[2] ?? ''] ?? words[2] ?? '') + 1, Number(words[1])]
        : [NaN, NaN, NaN];
  const at = new Date(Date.UTC(year, month - 1, day));
  const isReal =
    year >= 1000 &&
    year < 2200 &&
    at.getUTCFullYear() === year &&
    at.getUTCMonth() === month - 1 &&
    at.getUTCDate() === day;
  return isReal ? at.toISOString().slice(0, 10) : null;
}

/** A day as it is read, e.g. `31 Mar 2025`; in German in figures, as it is typed there. */
export function dayWords(iso: string): string {
  const [year = '', month = '', day = ''] = iso.split('-');
  if (formatLocale() === 'de') return `${day}.${month}.${year}`;
  const name = MONTHS[Number(month) - 1] ?? '';
  return `${Number(day)} ${name.charAt(0).toUpperCase()}${name.slice(1)} ${year}`;
}

const OLDEST_YEARS = 125;

/** Why nobody living was born on a day (`1850-01-01`), in words; null for a day that can be, and for none. */
export function birthError(iso: string, now = new Date()): string | null {
  if (iso === '' || readDay(iso) === null) return null;
  const year = Number(iso.slice(0, 4));
  const today = new Date(now.getTime() - now.getTimezoneOffset() * 60_000).toISOString().slice(0, 10);
  if (iso > today) return t('date.bornInFuture', { year });
  return year < now.getFullYear() - OLDEST_YEARS ? t('date.bornTooLongAgo', { year, years: OLDEST_YEARS }) : null;
}
