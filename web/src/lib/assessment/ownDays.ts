// A patient's own results by day: the curve of one measure, and the weeks in which she practised.
import type { ProgressMeasure } from '../../api/types';

const begin = (at: string | Date) => {
  const day = new Date(at);
  return new Date(day.getFullYear(), day.getMonth(), day.getDate());
};
/** Days are stepped by the calendar: one of them is an hour shorter when the clock is put forward. */
const plusDays = (day: Date, count: number) => new Date(day.getFullYear(), day.getMonth(), day.getDate() + count);
const monday = (day: Date) => plusDays(day, -((day.getDay() + 6) % 7));

export interface DayValue {
  day: string;
  value: number;
}

/** One value a day, oldest first: the mean over all repetitions of the day, as the caseload draws it. */
export function valuesByDay({ points }: Pick<ProgressMeasure, 'points'>): DayValue[] {
  const days = new Map<number, { sum: number; count: number }>();
  for (const one of points) {
    const day = begin(one.at).getTime();
    const { sum, count } = days.get(day) ?? { sum: 0, count: 0 };
    days.set(day, { sum: sum + one.count * one.value, count: count + one.count });
  }
  return [...days.entries()]
    .filter(([, { count }]) => count > 0)
    .sort(([a], [b]) => a - b)
    .map(([day, { sum, count }]) => ({ day: new Date(day).toISOString(), value: sum / count }));
}

export interface CalendarDay {
  at: Date;
  /** `unknown`: still to come, or before the oldest session that is known here. */
  state: 'practised' | 'free' | 'unknown';
}

/**
 * The last weeks from Monday to Sunday, oldest first.
 *
 * `isWhole` is false while older sessions are not loaded: of a day before the oldest one nothing is claimed.
 */
export function practisedWeeks(at: readonly string[], isWhole: boolean, now = new Date(), most = 4): CalendarDay[][] {
  const days = at.map((one) => begin(one).getTime());
  if (days.length === 0) return [];
  const practised = new Set(days);
  const oldest = Math.min(...days);
  const today = begin(now).getTime();
  const weeks = Array.from({ length: most }, (_, index) => plusDays(monday(begin(now)), 7 * (index + 1 - most)));
  return weeks
    .map((first) =>
      Array.from({ length: 7 }, (_, index): CalendarDay => {
        const day = plusDays(first, index);
        const time = day.getTime();
        if (practised.has(time)) return { at: day, state: 'practised' };
        return { at: day, state: time > today || (!isWhole && time < oldest) ? 'unknown' : 'free' };
      }),
    )
    .filter((week) => (week[6]?.at.getTime() ?? 0) >= oldest);
}
