// Sessions by day: a busy day is one point of a course, not a smear.
import type { ProgressMeasure } from '../../api/types';

type Point = ProgressMeasure['points'][number];

export interface Day {
  /** When its sessions were, in the mean; s since the epoch. */
  atS: number;
  value: number;
  low: number;
  high: number;
  sessions: Point[];
}

const mean = (values: readonly number[]) => values.reduce((sum, value) => sum + value, 0) / values.length;

/** The points of each day, by the clocks of who reads, oldest first. */
export function daysOf(points: readonly Point[]): Day[] {
  const days = new Map<string, Point[]>();
  for (const point of points) {
    const day = new Date(point.at).toDateString();
    days.set(day, [...(days.get(day) ?? []), point]);
  }
  return [...days.values()].map((sessions) => ({
    atS: mean(sessions.map((one) => Date.parse(one.at))) / 1000,
    value: mean(sessions.map((one) => one.value)),
    low: mean(sessions.map((one) => one.low)),
    high: mean(sessions.map((one) => one.high)),
    sessions,
  }));
}

/** Whatever has a moment, by the day on which it was, in its order. */
export function byDate<Event extends { at: string }>(events: readonly Event[]): Event[][] {
  const days = new Map<string, Event[]>();
  for (const event of events) {
    const day = new Date(event.at).toDateString();
    days.set(day, [...(days.get(day) ?? []), event]);
  }
  return [...days.values()];
}
