import { screen } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { afterEach, expect, it, vi } from 'vitest';
import { LiveButtons } from '../../src/pages/session/LiveButtons';
import { renderPage } from './render';

afterEach(() => vi.unstubAllGlobals());

it('lets a recording be stopped while the link is lost', async () => {
  const { asked } = renderPage(<LiveButtons sessionId="s" state="link_lost" isRecording />, { answers: { 'POST /api/sessions/s/stop': {} } });
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
