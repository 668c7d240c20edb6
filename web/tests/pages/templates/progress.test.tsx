// Progress: too few sessions are said with their number, the other side and norms with their source.
import { render, screen } from '@testing-library/react';
import axe from 'axe-core';
import { describe, expect, it, vi } from 'vitest';
import type { Estimator, ProgressMeasure } from '../../../src/api/types';
import { BandLegend, madeBy, ProgressChart, symmetryText, verdictOf } from '../../../src/charts/ProgressChart';

vi.mock('../../../src/charts/Plot', () => ({
  Plot: ({ label }: { label: string }) => <div role="img" aria-label={label} />,
  axis: (more: object) => more,
  themeColour: () => '#000',
}));

const measure = (change: Partial<ProgressMeasure>): ProgressMeasure => ({
  measure: 'range:a',
  label: 'Elbow flexion, range of motion',
  unit: 'deg',
  points: [],
  minimal_detectable_change: null,
  baseline_sessions: 3,
  bands: [],
  ...change,
});

describe('the verdict on a change', () => {
  it('says how many baseline sessions there are while there are too few', () => {
    expect(verdictOf(measure({ baseline_sessions: 2 }))).toMatch(/^Too few sessions .*: 2 of 3 for the baseline/);
    expect(verdictOf(measure({}))).toMatch(/^Not enough sessions/);
  });
  it('judges the newest session, whose value stands beside it, by the minimal detectable change', () => {
    const newest = {
      session_id: 's',
      at: '2026-04-01T10:00:00Z',
      value: 64,
      low: 62,
      high: 66,
      count: 8,
      orientation: 'telemotion 9',
      template_version_id: null,
    };
    const judged = (isReal: boolean) =>
      verdictOf(
        measure({
          points: [{ ...newest, change: 12, is_real_change: isReal }],
          minimal_detectable_change: 9.9,
        }),
      );
    expect(judged(true)).toBe(
      '+12° against the first three sessions: a real change, larger than the minimal detectable change of 10°.',
    );
    expect(judged(false)).toContain('not more than the minimal detectable change of 10°');
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
    change: null,
    is_real_change: null,
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
