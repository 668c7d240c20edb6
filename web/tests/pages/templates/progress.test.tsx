// Progress: too few sessions are said with their number, the other side and norms with their source.
import { render as draw, screen, within } from '@testing-library/react';
import axe from 'axe-core';
import type { ReactElement } from 'react';
import { MemoryRouter } from 'react-router';
import { describe, expect, it } from 'vitest';
import type { Estimator, ProgressMeasure } from '../../../src/api/types';
import { BandLegend, EventStrip, madeBy, ProgressChart, symmetryText } from '../../../src/charts/ProgressChart';
import { daysOf } from '../../../src/lib/assessment/days';
import { judgedBy, shownChange, trendNotes, trendText } from '../../../src/lib/assessment/trend';
import { changed, trend } from '../../trend';

const measure = (change: Partial<ProgressMeasure>): ProgressMeasure => ({
  measure: 'range:a',
  label: 'Elbow flexion, range of motion',
  unit: 'deg',
  points: [],
  trend: trend(),
  bands: [],
  ...change,
});

const render = (page: ReactElement) => draw(page, { wrapper: MemoryRouter });
const say = (words: ProgressMeasure['trend'], unit = 'deg') => trendText({ trend: words, unit });

describe('what is said of a change', () => {
  it('follows probability and size, and never calls unchanged what is not known', () => {
    expect(say(changed(39.4, 54.4, 3.2))).toBe('+15° ± 3 since 1 Jan (2.5° a week)');
    expect(say(changed(39.4, 41.4, 1.1, { word: 'a_little_more', important: 5 }))).toMatch(
      /^\+2° ± 1, smaller than what usually matters \(5°\) since/,
    );
    expect(say(changed(40, 46, 7, { word: 'probably_more' }))).toBe('+6° ± 7, probably more since 1 Jan');
    expect(say(changed(40, 41, 2, { word: 'unchanged' }))).toBe('unchanged: within ± 3° since 1 Jan');
    expect(say(changed(40, 42, 9, { word: 'unknown' }))).toBe('not yet known (± 9°) since 1 Jan');
    expect(say(trend({ days: 3 }))).toMatch(/^3 days: a change can be judged from four days on/);
  });
  it('is the difference of what is shown: rounded once, after subtracting', () => {
    expect(shownChange(changed(0.834, 0.944, 0.1), '1')).toEqual({ start: 0.83, now: 0.94, change: 0.11 });
    expect(shownChange(changed(3.6, 2.4, 1), '%')).toEqual({ start: 4, now: 2, change: -2 });
    expect(say(changed(3.6, 2.4, 1), '%')).toMatch(/^−2 percentage points ± 1 /);
    expect(shownChange(trend(), 'deg')).toBeNull();
  });
  it('says an unusual day, what breaks the series and by what it is judged', () => {
    const one = {
      unit: 'deg',
      trend: changed(40, 50, 3, {
        is_last_day_unusual: true,
        expected: 51,
        breaks: [{ at: '2026-01-20T10:00:00Z', kind: 'estimator' }],
        scatter: 1.4,
        minimal_detectable_change: 3.8,
        scatter_people: 12,
      }),
    };
    const [unusual, step] = trendNotes(one);
    expect(unusual).toMatch(/^The last day is unusual: 51° was expected/);
    expect(step).toMatch(/another estimator from 20 Jan on/);
    expect(judgedBy(one)).toMatch(/^Sessions differ by 1° .*this patient and 12 others of the clinic.* 4° without/);
  });
});

describe('days', () => {
  it('are a point each, and hold their sessions', () => {
    const at = (day: number, hour: number) => `2026-04-0${day}T${hour}:00:00`;
    const point = (when: string, value: number) => ({
      session_id: when,
      at: when,
      value,
      low: value - 1,
      high: value + 1,
      count: 8,
      orientation: 'telemotion 9',
      template_version_id: null,
    });
    const found = daysOf([point(at(1, 10), 50), point(at(2, 10), 60), point(at(2, 14), 64)]);
    expect(found.map((day) => [day.value, day.sessions.length])).toEqual([
      [50, 1],
      [62, 2],
    ]);
  });
  it('hold what happened on them, once for all charts', () => {
    const happened = [
      { at: '2026-04-01T10:00:00', kind: 'template', text: 'Template Reach, version 2' },
      { at: '2026-04-01T10:00:00', kind: 'prescription', text: 'Prescribed: 10' },
      { at: '2026-04-01T12:00:00', kind: 'pain', text: 'Stopped because it hurt' },
      { at: '2026-04-03T10:00:00', kind: 'pain', text: 'Stopped because it hurt' },
    ] as const;
    render(<EventStrip events={[...happened]} />);
    const strip = within(screen.getByRole('region', { name: 'Events' }));
    expect(strip.getAllByText(/Apr/)).toHaveLength(2);
    expect(strip.getByText('Prescribed: 10')).toBeTruthy();
  });
});

it('names what made a point in words, not as the service stores it', () => {
  const estimators = [{ name: 'telemotion', title: 'Telemotion, live' }] as unknown as Estimator[];
  expect(madeBy({ orientation: 'telemotion 9' }, estimators)).toBe('Telemotion, live (version 9)');
  expect(madeBy({ orientation: 'foot 1' }, estimators)).toBe('Foot tracking (version 1)');
});

it('says once what made all points, and in each line where they differ', () => {
  const point = (session_id: string, orientation: string) => ({
    session_id,
    at: '2026-04-01T10:00:00Z',
    value: 64,
    low: 62,
    high: 66,
    count: 8,
    orientation,
    template_version_id: null,
  });
  const show = (second: string) =>
    render(
      <ProgressChart
        measure={measure({ points: [point('a', 'foot 1'), point('b', second)] })}
        events={[]}
        estimators={[]}
      />,
    );
  const { unmount } = show('foot 1');
  expect(screen.getAllByText(/Foot tracking/).map((one) => one.tagName)).toEqual(['P']);
  unmount();
  show('foot 2');
  expect(screen.getAllByText(/Foot tracking/).map((one) => one.tagName)).toEqual(['TD', 'TD']);
});

describe('the other side', () => {
  it('is less or more only beyond twice the uncertainty', () => {
    expect(symmetryText(Math.log(0.8), 0.02, -7.04)).toBe(
      'On the affected side it is 20 % ± 2 % less (symmetry angle −7.0 %)',
    );
    expect(symmetryText(Math.log(1.1), 0.02, 3)).toContain('10 % ± 2 % more');
    expect(symmetryText(Math.log(0.97), 0.02, -1)).toMatch(/^Both sides alike within the uncertainty of 2 % /);
  });
  it('and norms stand below the curve with their source', async () => {
    const { container } = render(
      <BandLegend
        unit="deg"
        bands={[
          {
            kind: 'other_side',
            low: 48,
            high: 52,
            text: 'Other side (left), newest session, mean of 8',
            value: 50,
            symmetry_ratio: Math.log(0.8),
            symmetry_ratio_sigma: 0.02,
            symmetry_angle_percent: -7.04,
          },
          { kind: 'norm', low: 60, high: 70, text: 'Healthy people of 60 to 69 years (Somebody 2006)' },
        ]}
      />,
    );
    const [other, norm] = screen.getAllByRole('listitem');
    expect(other?.textContent).toContain('mean of 8: 48° – 52°. On the affected side it is 20 % ± 2 % less');
    expect(norm?.textContent).toContain('(Somebody 2006): 60° – 70°');
    const found = await axe.run(container, { rules: { 'color-contrast': { enabled: false } } });
    expect(found.violations.map((one) => one.id)).toEqual([]);
  });
});
