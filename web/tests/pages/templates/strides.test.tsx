// What of a walk is compared is called strides, not repetitions.
import { render, screen } from '@testing-library/react';
import { MantineProvider } from '@mantine/core';
import { expect, it } from 'vitest';
import type { ComparisonDetail } from '../../../src/api/types';
import { isOfStrides } from '../../../src/lib/assessment/comparison';
import { RepetitionTable } from '../../../src/pages/session/replay/RepetitionTable';

const comparison = (channel: string) =>
  ({
    repetition_count: 1,
    repetitions: [{ repetition: { number: 4, is_kept: true, reason: '' }, measures: [], outside_band: {} }],
    curves: [{ channel }],
    summary: [],
  }) as unknown as ComparisonDetail;

it.each([
  ['foot_height_right_m', 'Show stride 4', 'By stride'],
  ['thorax_humerus_right_yxy_elevation', 'Show repetition 4', 'By repetition'],
  ['shank_foot_right_zxy_flexion', 'Show repetition 4', 'By repetition'],
])('the table beside %s has a button to “%s”', (channel, name, title) => {
  render(
    <MantineProvider>
      <RepetitionTable comparison={comparison(channel)} selected={null} onSelect={() => undefined} />
    </MantineProvider>,
  );
  expect(screen.getByRole('button', { name })).toBeTruthy();
  expect(screen.getByRole('heading', { name: title })).toBeTruthy();
});

it('nothing compared is of no strides', () => {
  expect(isOfStrides(null)).toBe(false);
});
