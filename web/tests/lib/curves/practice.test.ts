import { expect, it } from 'vitest';
import { speakWith } from '../../../src/i18n';
import { words as german } from '../../../src/i18n/de';
import { words as english } from '../../../src/i18n/en';
import {
  activeText,
  isOpenToday,
  scheduleText,
  sessionsText,
  todayText,
  weekText,
} from '../../../src/lib/assessment/practice';

const week = (done: number, of: number, repetitions = 0, active = 0) => ({
  done_this_week: done,
  times_per_week: of,
  repetitions_this_week: repetitions,
  active_s_this_week: active,
});

it('says sessions, repetitions and time of the week', () => {
  expect(weekText(week(2, 3, 24, 360))).toBe('2 of 3 sessions this week · 24 repetitions · 6 min active');
  expect(weekText(week(1, 3, 0, 45))).toBe('1 of 3 sessions this week · 45 s active');
  expect(weekText(week(0, 1))).toBe('0 of 1 session this week');
  expect(weekText(week(1, 2, 1))).toBe('1 of 2 sessions this week · 1 repetition');
});

it('says what pain ended: it is not silently done', () => {
  const stopped = (done: number, stops: number) => ({ ...week(done, 3, 12), pain_stops_this_week: stops });
  expect(weekText(stopped(1, 1))).toBe('1 of 3 sessions this week, 1 stopped for pain · 12 repetitions');
  expect(weekText(stopped(0, 1))).toBe('0 of 3 sessions this week, 1 stopped for pain · 12 repetitions');
  expect(weekText(stopped(3, 1))).toBe('3 of 3 sessions this week, 1 stopped for pain · 12 repetitions');
  expect(weekText(stopped(2, 2))).toBe('2 of 3 sessions this week, 2 stopped for pain · 12 repetitions');
  speakWith('de', german);
  expect(sessionsText(stopped(1, 1))).toBe('1 von 3 Sitzungen diese Woche, 1 wegen Schmerzen beendet');
  speakWith('en', english);
});

it('never says thirteen of three', () => {
  expect(weekText(week(13, 3, 130, 1300))).toBe(
    '3 of 3 sessions this week · 10 more than prescribed · 130 repetitions · 22 min active',
  );
});

it('rounds time once', () => {
  expect(activeText(59.4)).toBe('59 s active');
  expect(activeText(59.6)).toBe('1 min active');
  expect(activeText(89)).toBe('1 min active');
  expect(activeText(91)).toBe('2 min active');
});

it('says the days and times of a prescription', () => {
  expect(scheduleText({ days: [1, 3, 5], times: ['09:00', '17:30'] })).toBe('Mon, Wed and Fri at 09:00 and 17:30');
  expect(scheduleText({ days: [7], times: [] })).toBe('Sun');
  expect(scheduleText({ days: [1, 2, 3, 4, 5, 6, 7], times: [] })).toBe('Every day');
  expect(scheduleText({ days: [], times: [] })).toBe('');
});

it('is due on its days, once for each of its times', () => {
  const of = (change: object) =>
    isOpenToday({
      days: [1, 3],
      times: [],
      is_due_today: true,
      goal: 0,
      goal_done: 0,
      done_today: 0,
      done_this_week: 0,
      times_per_week: 2,
      ...change,
    });
  expect(of({})).toBe(true);
  expect(of({ done_today: 1, done_this_week: 1 })).toBe(false);
  expect(of({ times: ['09:00', '17:00'], done_today: 1 })).toBe(true);
  expect(of({ is_due_today: false })).toBe(false);
  // What was missed on Monday is not made up by a full week elsewhere: Wednesday stays due.
  expect(of({ done_this_week: 5 })).toBe(true);
  expect(of({ days: [], done_this_week: 1 })).toBe(true);
  expect(of({ days: [], done_this_week: 2, is_due_today: true })).toBe(false);
  // A goal that was begun today is finished first.
  expect(of({ days: [], done_this_week: 2, goal: 10, goal_done: 4 })).toBe(true);
  expect(of({ days: [], done_this_week: 2, goal: 10, goal_done: 10, done_today: 1 })).toBe(false);
});

it('says what of today is done, as long as something is left', () => {
  const of = (done: number, goalDone: number, times: string[] = []) =>
    todayText({ goal: 10, goal_done: goalDone, done_today: done, times });
  expect(of(0, 0)).toBe('');
  expect(of(0, 4)).toBe('Today: 4 of 10 done');
  expect(of(1, 10)).toBe('');
  const twice = ['09:00', '17:00'];
  expect(of(0, 4, twice)).toBe('Time 1 of 2 today: 4 of 10 done');
  expect(of(1, 0, twice)).toBe('1 of 2 times done today');
  expect(of(1, 4, twice)).toBe('Time 2 of 2 today: 4 of 10 done');
  expect(of(2, 10, twice)).toBe('');
});
