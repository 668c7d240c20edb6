import { describe, expect, it } from 'vitest';
import { Grid, type Sample, type Tick } from '../../src/sensors/gateway/grid';

const STEP_MS = 1000 / 60;
/** A movement that is a line in time lies on the same line afterwards. */
const at = (ms: number): Sample => [ms, -ms, 2 * ms, 1, 0, 9.8];
const isMissing = (tick: Tick, sensor = 0) => tick.values.slice(6 * sensor, 6 * sensor + 6).every((one) => one === 0);

describe('Grid', () => {
  it('gives every sample of an even 60 Hz source back as it is, once', () => {
    const grid = new Grid(1, 60);
    const startMs = 1_790_000_000_000;
    const first = Math.ceil(startMs / STEP_MS);
    const ticks = Array.from({ length: 600 }, (_, n) =>
      grid.add(0, (first + n) * STEP_MS, [n, 0, 0, 0, 0, 9.8]),
    ).flat();
    expect(ticks).toHaveLength(600);
    ticks.forEach((tick, n) => expect(tick.values[0]).toBeCloseTo(n, 1));
    expect(new Set(ticks.map((tick) => tick.number)).size).toBe(600);
  });

  it('draws lines between samples that come unevenly', () => {
    const grid = new Grid(1, 60);
    const times = Array.from({ length: 300 }, (_, n) => 5 + n * 17.3 + 4 * Math.sin(n));
    const ticks = times.flatMap((ms) => grid.add(0, ms, at(ms)));
    expect(ticks.length).toBeGreaterThan(300);
    for (const tick of ticks) expect(tick.values[0]).toBeCloseTo(tick.number * STEP_MS, 2);
    ticks.forEach((tick, n) => expect(tick.number).toBe((ticks[0]?.number ?? 0) + n));
  });

  it('says that nothing was measured in a gap above 200 ms, and bridges a shorter one', () => {
    const grid = new Grid(1, 60);
    const ticks = [0, 17, 34, 184, 200, 700, 717, 734].flatMap((ms) => grid.add(0, ms, at(ms)));
    const missing = ticks.filter((tick) => isMissing(tick) && tick.number > 0).map((tick) => tick.number * STEP_MS);
    expect(Math.min(...missing)).toBeGreaterThan(200);
    expect(Math.max(...missing)).toBeLessThan(701);
    expect(missing.length).toBe(29);
  });

  it('begins anew after a pause instead of writing zeros', () => {
    const grid = new Grid(1, 60);
    const ticks = [0, 17, 34, 60_000, 60_017, 60_034].flatMap((ms) => grid.add(0, ms, at(ms)));
    expect(ticks.length).toBeLessThan(8);
    expect(ticks.slice(1).some((tick) => isMissing(tick))).toBe(false);
  });

  it('waits for the slower of two sensors, and no longer when that one is gone', () => {
    const grid = new Grid(2, 60);
    const both = (ms: number) => [...grid.add(0, ms, at(ms)), ...grid.add(1, ms - 30, at(ms - 30))];
    const together = Array.from({ length: 60 }, (_, n) => both(100 + n * 17)).flat();
    expect(together.slice(4).some((tick) => isMissing(tick, 0) || isMissing(tick, 1))).toBe(false);
    grid.leave(1);
    const ticks = Array.from({ length: 30 }, (_, n) => grid.add(0, 1120 + n * 17, at(1120 + n * 17))).flat();
    expect(ticks.length).toBeGreaterThan(28);
    expect(ticks.slice(3).every((tick) => isMissing(tick, 1) && !isMissing(tick, 0))).toBe(true);
  });
});
