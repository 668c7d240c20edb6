// What the patient said after an exercise, for who treats: marks with their ends, words, and nothing where nothing was said.
import { screen } from '@testing-library/react';
import axe from 'axe-core';
import { afterEach, describe, expect, it, vi } from 'vitest';
import type { Answers, SessionDetail } from '../../../src/api/types';
import { Said } from '../../../src/pages/session/replay/Said';
import { renderPage } from '../render';

afterEach(() => vi.unstubAllGlobals());

const session = { id: 's', exercise_id: 'e' } as SessionDetail;
const said: Answers = {
  pain: 7,
  effort: 0,
  third: null,
  note: 'The shoulder pulled.',
  question: 'Did you sleep well?',
  answered_at: '2026-11-25T10:00:00Z',
};

describe('what the patient said', () => {
  it('shows each answer that was given, zero as well', async () => {
    const { container } = renderPage(<Said session={session} />, { answers: { '/api/sessions/s/answers': said } });
    await screen.findByText('7 of 10');
    expect(screen.getByText('0 of 10')).toBeTruthy();
    expect(screen.getByText('The shoulder pulled.')).toBeTruthy();
    expect(screen.queryByText('Did you sleep well?')).toBeNull();
    const found = await axe.run(container, { rules: { 'color-contrast': { enabled: false } } });
    expect(found.violations).toEqual([]);
  });

  it('shows nothing before anything was said', async () => {
    const { container } = renderPage(<Said session={session} />, {
      answers: { '/api/sessions/s/answers': { ...said, answered_at: null } },
    });
    await new Promise((done) => setTimeout(done, 50));
    expect(container.querySelector('section')).toBeNull();
  });
});
