import { act, fireEvent, screen } from '@testing-library/react';
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { GuidedWalk, type GuidedWalkProps } from '../../../src/kinds/walk/views/GuidedWalk';
import type { Player } from '../../../src/player/types';
import { renderPage } from '../render';

const NOTHING = {
  clock: () => ({ timeS: 0, startS: 0, endS: 0, isPlaying: true, speed: 1 }),
  read: () => ({ timeS: new Float64Array(0), values: [], isComplete: true }),
} as unknown as Player;
const PROPS: GuidedWalkProps = {
  session: { id: 's', recording_start_s: null, recording_end_s: null },
  player: NOTHING,
  message: null,
  kind: 'six_minute_walk',
  state: 'ready',
  isRecording: false,
  mayRecord: true,
  delayS: 1,
};
const clock = () => screen.getByTestId('guided-clock').textContent;

beforeEach(() => vi.useFakeTimers());
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

it('counts a six-minute walk down from what the service says, prompts, and stops when asked', async () => {
  // Opened again after 58 seconds of recording.
  const { asked } = renderPage(
    <GuidedWalk {...PROPS} state="recording" isRecording message={{ session_time_s: 70, recording_start_s: 12 }} />,
    { answers: { 'POST /api/sessions/s/stop': {} } },
  );
  expect(clock()).toBe('5:02');
  expect(screen.getByRole('status').textContent).toBe('');
  act(() => void vi.advanceTimersByTime(3000));
  expect(clock()).toBe('4:59');
  expect(screen.getByRole('status').textContent).toBe('1 minute done, 5 to go.');
  expect(screen.getByRole('status').getAttribute('aria-live')).toBe('polite');
  act(() => void vi.advanceTimersByTime(300_000));
  expect(clock()).toBe('0:00');
  expect(screen.getByRole('status').textContent).toBe('Stop now.');
  fireEvent.click(screen.getByRole('button', { name: 'Finish the test' }));
  await act(() => vi.advanceTimersByTimeAsync(50));
  expect(asked.map((one) => `${one.method} ${one.path}`)).toEqual(['POST /api/sessions/s/stop']);
});

it('tells before the start what to do, and starts only when the session is ready', async () => {
  const { asked, unmount } = renderPage(<GuidedWalk {...PROPS} kind="timed_up_and_go" />, {
    answers: { 'POST /api/sessions/s/record': {} },
  });
  expect(
    screen
      .getAllByRole('listitem')
      .map((one) => one.textContent)
      .join(' '),
  ).toContain('3 m in front of a chair');
  expect(clock()).toBe('0:00.0');
  fireEvent.click(screen.getByRole('button', { name: 'Start the test' }));
  await act(() => vi.advanceTimersByTimeAsync(50));
  expect(asked.map((one) => one.path)).toEqual(['/api/sessions/s/record']);
  unmount();
  renderPage(<GuidedWalk {...PROPS} state="link_lost" />, { answers: {} });
  expect(clock()).toBe('6:00');
  expect(screen.getByRole('button', { name: 'Start the test' })).toHaveProperty('disabled', true);
});

it('shows how long was recorded when it is stopped, and nothing to press to who may not record', () => {
  renderPage(
    <GuidedWalk
      {...PROPS}
      kind="timed_up_and_go"
      mayRecord={false}
      session={{ id: 's', recording_start_s: 12, recording_end_s: 26.4 }}
      message={{ session_time_s: 30, recording_start_s: null }}
    />,
    { answers: {} },
  );
  expect(clock()).toBe('0:14.4');
  expect(screen.getByText('Recorded')).toBeTruthy();
  expect(screen.queryByRole('button')).toBeNull();
});
