import { act, screen } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { afterEach, expect, it, vi } from 'vitest';
import type { LiveSnapshot } from '../../../src/player/live';
import { LiveBanners } from '../../../src/pages/session/live/LiveBanners';
import { LiveButtons } from '../../../src/pages/session/live/LiveButtons';
import { renderPage } from '../render';

afterEach(() => vi.unstubAllGlobals());

it('lets a recording be stopped while the link is lost', async () => {
  const { asked } = renderPage(<LiveButtons sessionId="s" state="link_lost" isRecording />, {
    answers: { 'POST /api/sessions/s/stop': {} },
  });
  expect(screen.queryByRole('button', { name: 'Start recording' })).toBeNull();
  await userEvent.click(screen.getByRole('button', { name: 'Stop recording' }));
  expect(asked.map((one) => `${one.method} ${one.path}`)).toContain('POST /api/sessions/s/stop');
});

it('does not start recording before the sensors are calibrated', () => {
  renderPage(<LiveButtons sessionId="s" state="calibrating" isRecording={false} />, { answers: {} });
  expect(screen.getByRole('button', { name: 'Start recording' })).toHaveProperty('disabled', true);
});

it('leaves starting and stopping to the card of a walking test', () => {
  renderPage(<LiveButtons sessionId="s" state="recording" isRecording isGuided />, { answers: {} });
  expect(screen.queryByRole('button', { name: 'Stop recording' })).toBeNull();
  expect(screen.getByRole('button', { name: 'End session' })).toBeTruthy();
});

const snapshot = (change: Partial<LiveSnapshot>) =>
  ({ connection: 'open', problem: null, lostSinceS: null, silentSinceS: null, state: null, ...change }) as LiveSnapshot;

/** The banner's words at the start and after some seconds. */
function banner(change: Partial<LiveSnapshot>, laterS: number, isLinkLost = false): [string, string] {
  vi.useFakeTimers({ now: new Date(2025, 0, 1, 12, 3, 2) });
  try {
    renderPage(<LiveBanners snapshot={snapshot(change)} isLinkLost={isLinkLost} />, { answers: {} });
    const [shown, ...others] = screen.getAllByRole('alert');
    expect(others).toHaveLength(0);
    const first = shown?.textContent ?? '';
    act(() => void vi.advanceTimersByTime(laterS * 1000));
    return [first, shown?.textContent ?? ''];
  } finally {
    vi.useRealTimers();
  }
}
const AT_S = new Date(2025, 0, 1, 12, 3, 0).getTime() / 1000;

it('says only what is known while the service is out of reach', () => {
  const [first, later] = banner({ connection: 'lost', lostSinceS: AT_S, silentSinceS: AT_S }, 5);
  expect(first).toContain('Connection to the service lost since 12:03:00');
  expect(first).toContain('This page does not know whether the session is being stored.');
  expect(first).toContain('Lost for 2 s');
  expect(later).toContain('Lost for 7 s');
});

it('names the network that refuses the socket, whom to ask, and what HTTP knows', () => {
  renderPage(
    <LiveBanners
      snapshot={snapshot({ connection: 'lost', lostSinceS: AT_S, isBlocked: true })}
      isLinkLost={false}
      known={{ state: 'recording', packets_stored: 1234 }}
    />,
    { answers: {} },
  );
  const words = screen.getByRole('alert').textContent;
  expect(words).toContain('Live connection lost since 12:03:00');
  expect(words).toContain('This network does not let the live connection (WebSocket) through. Ask whoever runs');
  expect(words).toContain('Recording, 1,234 packets stored');
  expect(words).not.toContain('does not know whether');
});

it('counts the silence of the sensors, with one banner whoever notices first', () => {
  const [first, later] = banner({ silentSinceS: AT_S }, 3, true);
  expect(first).toContain('No data from the sensors since 12:03:00');
  expect(first).toContain('Silent for 2 s');
  expect(later).toContain('Silent for 5 s');
});

it('claims no time for a silence that began before the page was opened', () => {
  const [first, later] = banner({}, 4, true);
  expect(first).not.toMatch(/since/);
  expect(later).toContain('This page has waited for 4 s');
});

it('notices silence before the service says so, but not while nothing is to come', () => {
  const state = (state: string) => ({ state }) as LiveSnapshot['state'];
  expect(banner({ silentSinceS: AT_S, state: state('recording') }, 0)[0]).toContain('No data');
  renderPage(
    <div data-testid="quiet">
      <LiveBanners snapshot={snapshot({ silentSinceS: AT_S, state: state('calibrating') })} isLinkLost={false} />
    </div>,
    { answers: {} },
  );
  expect(screen.getByTestId('quiet').textContent).toBe('');
});
