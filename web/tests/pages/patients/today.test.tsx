// Today's card: what of the day's goal is done, and when nothing more is to do.
import { cleanup, screen } from '@testing-library/react';
import { afterEach, expect, it, vi } from 'vitest';
import type { Me } from '../../../src/api/types';
import { speakLanguage } from '../../../src/i18n/languages';
import { TodayPage } from '../../../src/pages/mine/Today';
import { renderPage, THERAPIST } from '../render';

afterEach(async () => {
  vi.unstubAllGlobals();
  await speakLanguage('en');
});

const OWN: Me = { ...THERAPIST, role: 'patient', display_name: 'Ada Berg', patient_id: 'p' };

function open(change: object) {
  cleanup();
  const prescription = {
    id: 'pr',
    exercise_id: 'e',
    exercise_name: 'Reach',
    template_id: 't',
    repetitions: 10,
    sets: 1,
    days: [1, 2, 3, 4, 5, 6, 7],
    times: [],
    times_per_week: 7,
    is_due_today: true,
    goal: 10,
    goal_done: 0,
    done_today: 0,
    done_this_week: 1,
    ...change,
  };
  renderPage(<TodayPage />, {
    me: OWN,
    answers: {
      '/api/patients/p': { id: 'p', affected_side: 'right' },
      '/api/patients/p/prescriptions': [prescription],
      '/api/patients/p/sessions': [],
      '/api/patients/p/progress': { measures: [] },
      '/api/exercises': [{ id: 'e', name: 'Reach', movement: 'reaching', description: '' }],
    },
  });
}

it('says what of today is done until all is', async () => {
  open({ goal_done: 4 });
  expect(await screen.findByText('Today: 4 of 10 done')).toBeTruthy();
  expect(await screen.findByRole('button', { name: 'Continue: Reach' })).toBeTruthy();
  expect(screen.queryByText('Nothing more for today')).toBeNull();

  open({ goal_done: 10, done_today: 1 });
  expect(await screen.findByText('Nothing more for today')).toBeTruthy();
  expect(screen.getByRole('button', { name: 'Do it again: Reach' })).toBeTruthy();
});

it('says it of each of several times a day, also in German', async () => {
  const twice = { times: ['09:00', '17:00'], times_per_week: 14, done_today: 1 };
  open({ ...twice, goal_done: 0 });
  expect(await screen.findByText('1 of 2 times done today')).toBeTruthy();
  expect(await screen.findByRole('button', { name: 'Start: Reach' })).toBeTruthy();

  await speakLanguage('de');
  open({ ...twice, goal_done: 4 });
  expect(await screen.findByText('2. von 2 Malen heute: 4 von 10 geschafft')).toBeTruthy();
  open({ goal_done: 4 });
  expect(await screen.findByText('Heute: 4 von 10 geschafft')).toBeTruthy();
});
