import { describe, expect, it } from 'vitest';
import { countdown, minutePrompt, SessionClock, WalkTally, walkKind } from '../../src/kinds/walk/guidedWalk';
import type { Player } from '../../src/player/types';

describe('the clock of a walking test', () => {
  it('counts six minutes down and says each full minute', () => {
    expect([0, 0.4, 59.99, 60, 359.2, 360, 400].map(countdown)).toEqual([
      '6:00',
      '6:00',
      '5:01',
      '5:00',
      '0:01',
      '0:00',
      '0:00',
    ]);
    expect([59, 60, 125, 359.9, 360].map(minutePrompt)).toEqual([
      '',
      '1 minute done, 5 to go.',
      '2 minutes done, 4 to go.',
      '5 minutes done, 1 to go.',
      'Stop now.',
    ]);
  });

  it('goes on between messages and over a lost link, and never back', () => {
    let wallS = 100;
    const clock = new SessionClock(() => wallS);
    expect(clock.read()).toBeNull();
    clock.set(50);
    wallS = 103;
    expect(clock.read()).toBe(53);
    // A frame that came late, and one of those that are sent again.
    clock.set(52.8);
    clock.set(20);
    expect(clock.read()).toBe(53);
    // A stream faster than real time.
    clock.set(80);
    wallS = 104;
    expect(clock.read()).toBe(81);
  });

  it('takes whatever is no test for a walk', () => {
    expect(['six_minute_walk', 'timed_up_and_go', 'walk', 'reaching', undefined].map(walkKind)).toEqual([
      'six_minute_walk',
      'timed_up_and_go',
      'walk',
      'walk',
      'walk',
    ]);
  });
});

/** Frames at 10 Hz: both feet step in turn to the places of a course, a second each. */
function walking(course: readonly number[]) {
  const rows: { timeS: number; values: Record<string, number> }[] = [];
  course.forEach((_, k) => {
    for (let tick = 0; tick < 10; tick += 1) {
      const values: Record<string, number> = {};
      (['left', 'right'] as const).forEach((side, index) => {
        const isMine = k % 2 === index && k > 0;
        const held = course[k % 2 === index ? k : k - 1] ?? course[0];
        const from = course[Math.max(k - 2, 0)] ?? 0;
        values[`foot_${side}_stance`] = isMine && tick < 5 ? 0 : 1;
        values[`foot_${side}.x`] = isMine && tick < 5 ? from : (held ?? 0);
        values[`foot_${side}.y`] = 0;
      });
      rows.push({ timeS: k + tick / 10, values });
    }
  });
  let endS = 0;
  const player = {
    clock: () => ({ timeS: endS, startS: 0, endS, isPlaying: true, speed: 1 }),
    read: (from: number, to: number, columns: readonly string[]) => {
      const chosen = rows.filter((row) => row.timeS >= from && row.timeS < to);
      return {
        timeS: new Float64Array(chosen.map((row) => row.timeS)),
        values: columns.map((name) => new Float32Array(chosen.map((row) => row.values[name] ?? NaN))),
        isComplete: true,
      };
    },
  } as unknown as Player;
  return { player, until: (timeS: number) => void (endS = timeS), lengthS: course.length };
}

describe('what the feet have done so far', () => {
  // Each foot goes out to 3.2 m and back to where it stood.
  const course = [0, 0.4, 0.8, 1.2, 1.6, 2.0, 2.4, 2.8, 3.2, 3.2, 2.8, 2.4, 2.0, 1.6, 1.2, 0.8, 0.4, 0, 0];

  it('counts steps and way, however the frames arrive, and knows the leg of a timed up and go', () => {
    const { player, until, lengthS } = walking(course);
    const tally = new WalkTally(0);
    const legs: string[] = [];
    for (let timeS = 0.7; timeS < lengthS + 1; timeS += 0.7) {
      until(timeS);
      tally.take(player);
      const { leg } = tally.read();
      if (legs.at(-1) !== leg) legs.push(leg);
    }
    const found = tally.read();
    expect(legs).toEqual(['out', 'turn', 'back', 'there']);
    expect(found.distanceM).toBeCloseTo(6.4, 3);
    const once = walking(course);
    once.until(lengthS);
    const batch = new WalkTally(0);
    batch.take(once.player);
    expect(batch.read()).toEqual(found);
    expect(found.steps).toBe(18);
    expect(tally.isWhole).toBe(true);
  });

  it('counts nobody who stands, and says when it began late', () => {
    const { player, until } = walking([0, 0, 0, 0, 0.05, 0]);
    until(6);
    const tally = new WalkTally(0);
    expect(tally.read()).toEqual({ distanceM: null, steps: 0, awayM: null, leg: 'out' });
    tally.take(player);
    expect(tally.read()).toMatchObject({ distanceM: 0, steps: 0 });
    const late = new WalkTally(-40);
    late.take(player);
    expect(late.isWhole).toBe(false);
    expect(late.countedFromS).toBe(0);
  });
});
