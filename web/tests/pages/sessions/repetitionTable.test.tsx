// The table by repetition: one part of its columns at a time, why a repetition is left out in a line of its own.
import { MantineProvider } from '@mantine/core';
import { render, screen } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { expect, it } from 'vitest';
import type { ComparisonDetail } from '../../../src/api/types';
import { RepetitionTable } from '../../../src/pages/session/replay/RepetitionTable';

const measure = (name: string, group: string) => ({
  measure: name,
  label: name,
  group,
  unit: 's',
  value: 1.5,
  uncertainty: 0.2,
  count: 1,
});
const MANY = [
  measure('duration', 'timing'),
  measure('timing_deviation', 'timing'),
  measure('shape_deviation', 'shape'),
  measure('inside_band', 'shape'),
  measure('peak_speed', 'path'),
  measure('spectral_arc_length', 'smoothness'),
  measure('log_dimensionless_jerk', 'smoothness'),
  measure('joint_correlation', 'coordination'),
];

function show(measures: typeof MANY) {
  const comparison = {
    repetition_count: 1,
    repetitions: [
      { repetition: { number: 1, is_kept: false, reason: 'Too fast.' }, measures, outside_band: {} },
      { repetition: { number: 2, is_kept: true, reason: '' }, measures, outside_band: {} },
    ],
    curves: [{ channel: 'thorax_humerus_right_yxy_elevation' }],
    summary: measures,
  } as unknown as ComparisonDetail;
  render(
    <MantineProvider>
      <RepetitionTable comparison={comparison} selected={null} onSelect={() => undefined} />
    </MantineProvider>,
  );
}

const isFolded = (label: string) =>
  screen.getByRole('columnheader', { name: label }).classList.contains('column-folded');

it('folds path and smoothness until they are asked for', async () => {
  show(MANY);
  expect(isFolded('duration')).toBe(false);
  expect(isFolded('peak_speed')).toBe(true);
  await userEvent.click(screen.getByRole('radio', { name: 'Path and smoothness' }));
  expect(isFolded('duration')).toBe(true);
  expect(isFolded('peak_speed')).toBe(false);
});

it('has no switch where all columns have room', () => {
  show(MANY.slice(0, 6));
  expect(screen.queryByRole('radio')).toBeNull();
  expect(isFolded('peak_speed')).toBe(false);
});

it('says why a repetition is left out below its values', () => {
  show(MANY);
  const said = screen.getByRole('cell', { name: 'Too fast.' });
  expect(said.getAttribute('colspan')).toBe('5');
  expect(screen.getAllByRole('row')).toHaveLength(1 + 3 + 2);
});
