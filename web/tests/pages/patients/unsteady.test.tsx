// "Hold still" that does not come to an end: which part moves, and after a while another way.
import { act, cleanup, render, screen } from '@testing-library/react';
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import type { CalibrationMessage } from '../../../src/api/types';
import { Unsteady } from '../../../src/pages/mine/Live';

beforeEach(() => void vi.useFakeTimers());
afterEach(() => {
  cleanup();
  vi.useRealTimers();
});

const guide = (code: string | null, hint: string) =>
  ({ hint, sentences: code ? { hint: { code, parameters: {} } } : {} }) as unknown as CalibrationMessage;
const pass = (ms: number) => act(() => vi.advanceTimersByTime(ms));
const MOVED = guide('live.moved', 'The left hand moves.');

it('names the part at once, long enough to be read, and offers another way after 20 s', () => {
  const { rerender } = render(<Unsteady guide={guide(null, '')} />);
  expect(screen.getByRole('status').textContent).toBe('');
  pass(1000);
  rerender(<Unsteady guide={MOVED} />);
  expect(screen.getByText('The left hand moves.')).toBeTruthy();
  // A tremor comes and goes.
  rerender(<Unsteady guide={guide(null, '')} />);
  pass(3900);
  expect(screen.getByText('The left hand moves.')).toBeTruthy();
  pass(200);
  expect(screen.queryByText('The left hand moves.')).toBeNull();
  pass(14_800);
  expect(screen.getByRole('status').textContent).toBe('');
  pass(200);
  expect(screen.getByRole('status').textContent).toMatch(/\w{3}/);
  rerender(<Unsteady guide={MOVED} />);
  expect(screen.getByRole('status').children).toHaveLength(2);
});

it('says nothing of what does not keep the pose from being held', () => {
  render(<Unsteady guide={guide('live.other', 'Something else.')} />);
  pass(5000);
  expect(screen.getByRole('status').textContent).toBe('');
});
