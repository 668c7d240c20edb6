// What was done of a prescription this week, in words.
import type { Prescription } from '../../api/types';
import { formatLocale, t } from '../../i18n';

/** Days of the week as the service numbers them: 1 is Monday. */
export const DAYS = [1, 2, 3, 4, 5, 6, 7] as const;
/** A Monday. */
const MONDAY_MS = Date.UTC(2024, 0, 1, 12);
const DAY_MS = 86_400_000;

/** The name of a day of the week, e.g. `Mon` or `Monday`. */
export function dayName(day: number, length: 'short' | 'long'): string {
  const at = new Date(MONDAY_MS + (day - 1) * DAY_MS);
  return new Intl.DateTimeFormat(formatLocale(), { weekday: length, timeZone: 'UTC' }).format(at);
}

const listed = (words: readonly string[]) => new Intl.ListFormat(formatLocale(), { type: 'conjunction' }).format(words);

/** For instance `Mon, Wed and Fri at 09:00 and 17:30`; empty where any day will do. */
export function scheduleText({ days, times }: Pick<Prescription, 'days' | 'times'>): string {
  if (days.length === 0) return '';
  const on = days.length === DAYS.length ? t('practice.daily') : listed(days.map((one) => dayName(one, 'short')));
  return times.length ? t('practice.at', { days: on, times: listed(times) }) : on;
}

type Goal = Pick<Prescription, 'goal' | 'goal_done'>;
type Today = Goal & Pick<Prescription, 'times' | 'done_today'>;
type Due = Today & Pick<Prescription, 'days' | 'is_due_today' | 'done_this_week' | 'times_per_week'>;

/** Whether as much was done this week as is prescribed. */
export function isDoneForWeek(one: Pick<Prescription, 'done_this_week' | 'times_per_week'>): boolean {
  return one.done_this_week >= one.times_per_week;
}

/** Whether something of the day's goal was done, and not yet all of it. */
export function isBegun({ goal, goal_done: done }: Goal): boolean {
  return done > 0 && done < goal;
}

const timesOf = ({ times }: Pick<Prescription, 'times'>) => Math.max(1, times?.length ?? 0);

/** Whether it is still to be done today: on its days once for each of its times, otherwise until the week is full. */
export function isOpenToday(one: Due): boolean {
  if (!one.days?.length) return isBegun(one) || !isDoneForWeek(one);
  return one.is_due_today && one.done_today < timesOf(one);
}

/** For instance `Today: 4 of 10 done`, where several times a day are prescribed of which; empty where none is begun. */
export function todayText(one: Today): string {
  const times = timesOf(one);
  const of = { done: one.goal_done, goal: one.goal, number: one.done_today + 1, times };
  if (isBegun(one)) return t(times > 1 ? 'mine.goalOfTime' : 'mine.goal', of);
  return one.done_today > 0 && one.done_today < times ? t('mine.timesDone', { done: one.done_today, times }) : '';
}

type Sessions = Pick<Prescription, 'done_this_week' | 'times_per_week' | 'pain_stops_this_week'>;
type Week = Sessions & Pick<Prescription, 'repetitions_this_week' | 'active_s_this_week'>;

/** For instance `1 stopped for pain`: beside a count it must not seem to be of the sessions that were done; empty for none. */
export function painText({ pain_stops_this_week: stops = 0 }: Pick<Sessions, 'pain_stops_this_week'>): string {
  return stops ? t('practice.pain', { count: stops }) : '';
}

/** For instance `1 of 3 sessions this week, 1 stopped for pain`: what pain ended is never silently done. */
export function sessionsText(week: Sessions): string {
  const { done_this_week: done, times_per_week: of } = week;
  return [t('practice.sessions', { done: Math.min(done, of), count: of }), painText(week)].filter(Boolean).join(', ');
}

/** Time of exercise: seconds below a minute, else whole minutes. */
export function activeText(seconds: number): string {
  return seconds < 59.5
    ? t('practice.seconds', { seconds: Math.round(seconds) })
    : t('practice.minutes', { minutes: Math.round(seconds / 60) });
}

/** For instance `2 of 3 sessions this week · 24 repetitions · 6 min active`; more than prescribed are named apart. */
export function weekText(week: Week): string {
  const { done_this_week: done, times_per_week: of } = week;
  return [
    sessionsText(week),
    done > of && t('practice.more', { count: done - of }),
    week.repetitions_this_week > 0 && t('prescription.repetitions', { count: week.repetitions_this_week }),
    week.active_s_this_week >= 0.5 && activeText(week.active_s_this_week),
  ]
    .filter(Boolean)
    .join(' · ');
}
