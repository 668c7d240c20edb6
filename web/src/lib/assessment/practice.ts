// What was done of a prescription this week, in words.
import type { Prescription } from '../../api/types';
import { t } from '../../i18n';

type Week = Pick<Prescription, 'done_this_week' | 'times_per_week' | 'repetitions_this_week' | 'active_s_this_week'>;

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
    t('practice.sessions', { done: Math.min(done, of), count: of }),
    done > of && t('practice.more', { count: done - of }),
    week.repetitions_this_week > 0 && t('prescription.repetitions', { count: week.repetitions_this_week }),
    week.active_s_this_week >= 0.5 && activeText(week.active_s_this_week),
  ]
    .filter(Boolean)
    .join(' · ');
}
