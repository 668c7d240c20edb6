import { screen } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { afterEach, describe, expect, it, vi } from 'vitest';
import type { AccuracyFigure, AccuracyProtocol, AccuracyReport } from '../../src/api/types';
import { AccuracyPage } from '../../src/pages/Accuracy';
import { renderPage } from './render';

vi.mock('../../src/charts/LineChart', () => ({ LineChart: ({ label }: { label: string }) => <div role="img" aria-label={label} /> }));
afterEach(() => vi.unstubAllGlobals());

const figure = (passed: boolean): AccuracyFigure => ({ name: 'error', unit: 'deg', published: 2, required: 1, at_most: true, judged_by: 'worst', median: 0.5, worst: passed ? 0.8 : 1.8, spread: 0.1, values: [0.5], passed });
const protocol = (name: string, passed: boolean): AccuracyProtocol => ({ name, title: `Experiment ${name}`, source: 'Somebody 2009', what: `What ${name} does.`, passed, seeds: 20, seconds: 3, figures: [figure(passed)], plots: [] });
const REPORT: AccuracyReport = { format: 1, version: '0.1.0', made_at: '2026-11-21T10:00:00Z', command: 'telemotion validate --seeds 20', seeds: 20, machine: 'Linux', data: [], seconds: 6, passed: false, protocols: [protocol('one', true), protocol('two', false)] };

describe('the accuracy page', () => {
  it('opens what falls short, and what is asked for', async () => {
    const user = userEvent.setup();
    renderPage(<AccuracyPage />, { at: '/accuracy', path: '/accuracy', answers: { '/api/accuracy': REPORT } });
    expect(await screen.findByText('What two does.')).toBeTruthy();
    expect(screen.queryByText('What one does.')).toBeNull();
    await user.click(screen.getByRole('link', { name: 'Experiment one' }));
    expect(await screen.findByText('What one does.')).toBeTruthy();
    expect(screen.getByText('1 of 2 experiments meet the requirement')).toBeTruthy();
  });
});
