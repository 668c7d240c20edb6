import { render } from '@testing-library/react';
import { expect, it } from 'vitest';
import type { PhaseCurve } from '../../../src/api/types';
import { PhaseChart } from '../../../src/charts/PhaseChart';
import { bandEdges } from '../../../src/lib/assessment/comparison';

const curve: PhaseCurve = {
  channel: 'a',
  label: 'Elbow flexion',
  unit: 'deg',
  mean: Array.from({ length: 101 }, (_, at) => (at < 5 ? null : 10)),
  low: Array.from({ length: 101 }, (_, at) => (at < 5 || at > 60 ? null : 8)),
  high: Array.from({ length: 101 }, (_, at) => (at < 5 ? null : 13)),
  width: Array.from({ length: 101 }, (_, at) => (at < 5 ? null : 3)),
  is_judged: true,
  repetitions: [Array.from({ length: 101 }, (_, at) => (at === 30 ? 20 : 6))],
};

it('draws what is free to the rim, and leaves a gap a gap', () => {
  const { low, high } = bandEdges(curve);
  expect([low[0], low[50], low[80]]).toEqual([null, 8, 6]);
  expect([high[0], high[80]]).toEqual([null, 13]);
});

it('prints the band, the named phases and red stretches where a repetition leaves it', () => {
  const view = render(
    <PhaseChart
      isOnPaper
      curve={curve}
      left={new Set()}
      outside={[{ repetition: 0, number: 1, from: 28, until: 33 }]}
      phases={[
        { name: 'Lift', start: 0.1, end: 0.45 },
        { name: 'Lower it slowly to the table', start: 0.55, end: 0.7 },
      ]}
    />,
  );
  const names = [...view.container.querySelectorAll('.chart-phase text')].map((one) => one.textContent);
  expect(names).toEqual(['Lift', 'Lower…']);
  expect(view.container.querySelector('.chart-band')?.getAttribute('d')?.length).toBeGreaterThan(100);
  expect(view.container.querySelectorAll('.chart-outside')).toHaveLength(1);
  expect(view.container.querySelectorAll('.chart-outside-bar')).toHaveLength(1);
});
