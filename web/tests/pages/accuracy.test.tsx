import { screen } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { afterEach, describe, expect, it, vi } from 'vitest';
import type { AccuracyFigure, AccuracyProtocol, AccuracyReport } from '../../src/api/types';
import { AccuracyPage } from '../../src/pages/Accuracy';
import { renderPage } from './render';

vi.mock('../../src/charts/LineChart', () => ({
  LineChart: ({ label }: { label: string }) => <div role="img" aria-label={label} />,
}));
afterEach(() => vi.unstubAllGlobals());

const JUDGED = { pass: [0.7, 0.6, 0.8], open: [0.9, 0.7, 1.3], short: [1.8, 1.5, 2.1] } as const;
type Verdict = AccuracyFigure['verdict'];
const figure = (verdict: Verdict): AccuracyFigure => {
  const [judged, low, high] = JUDGED[verdict];
  return {
    name: 'error',
    unit: 'deg',
    published: 2,
    required: 1,
    at_most: true,
    judged_by: 'worst',
    median: 0.5,
    worst: high,
    spread: 0.1,
    values: [0.5],
    each: 'seed',
    judged,
    low,
    high,
    verdict,
  };
};
const protocol = (name: string, verdict: Verdict): AccuracyProtocol => ({
  name,
  title: `Experiment ${name}`,
  source: 'Somebody 2009',
  what: `What ${name} does.`,
  verdict,
  seeds: 50,
  first_seed: 7,
  seconds: 3,
  figures: [figure(verdict)],
  plots: [],
});
const REPORT: AccuracyReport = {
  format: 2,
  version: '0.1.0',
  made_at: '2026-11-21T10:00:00Z',
  command: 'telemotion validate --seeds 50',
  seeds: 50,
  first_seed: 7,
  machine: 'Linux',
  data: [],
  seconds: 9,
  protocols: [protocol('one', 'pass'), protocol('two', 'short'), protocol('three', 'open')],
};

describe('the accuracy page', () => {
  it('opens what falls short, and what is asked for', async () => {
    const user = userEvent.setup();
    renderPage(<AccuracyPage />, { at: '/accuracy', path: '/accuracy', answers: { '/api/accuracy': REPORT } });
    expect(await screen.findByText('What two does.')).toBeTruthy();
    expect(screen.queryByText('What one does.')).toBeNull();
    await user.click(screen.getByRole('link', { name: 'Experiment one' }));
    expect(await screen.findByText('What one does.')).toBeTruthy();
    expect(screen.getByText('1 of 3 experiments meet the requirement')).toBeTruthy();
    expect(screen.getByText('1 are open: the limit lies within the confidence interval. 1 fall short.')).toBeTruthy();
    expect(screen.getByText('1.5° to 2.1°')).toBeTruthy();
  });

  it('shows the mean of a figure without a limit, and how many values it is of', async () => {
    const shown = { ...figure('pass'), required: null, judged_by: 'mean' as const, values: [0.5, 0.7, 0.9] };
    const report = { ...REPORT, protocols: [{ ...protocol('two', 'short'), figures: [shown] }] };
    renderPage(<AccuracyPage />, { at: '/accuracy', path: '/accuracy', answers: { '/api/accuracy': report } });
    expect(await screen.findByText('0.6° to 0.8°')).toBeTruthy();
    expect(screen.getByRole('cell', { name: '0.7°' })).toBeTruthy();
    expect(screen.getByRole('columnheader', { name: 'Count' })).toBeTruthy();
    expect(screen.getByRole('cell', { name: '3' })).toBeTruthy();
  });
});
