// What nobody has seen yet: on the caseload and on the patient's page, with her own words, and the mark itself.
import { screen, waitFor, within } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { expect, it } from 'vitest';
import type { CaseloadRow, Patient, Worry } from '../../../src/api/types';
import { CaseloadPage } from '../../../src/pages/Caseload';
import { WorryPanel } from '../../../src/pages/patient/WorryPanel';
import { renderPage } from '../render';

const worry = (change: Partial<Worry>): Worry => ({
  session_id: 's',
  kind: 'pain',
  at: '2026-11-20T10:00:00Z',
  known_at: '2026-11-20T10:05:00Z',
  text: 'The session was stopped because it hurt; pain 6 of 10.',
  words: 'Es zog in der Schulter',
  exercise_name: 'Reach forward',
  seen_at: null,
  seen_by: null,
  sentences: {},
  ...change,
});
const named = { session_id: 's', kind: 'pain', known_at: '2026-11-20T10:05:00Z' };
const row = {
  patient_id: 'p',
  given_name: 'Amara',
  family_name: 'Okafor',
  reason: 'pain',
  reason_text: worry({}).text,
  worry: worry({}),
  worry_count: 3,
  may_treat: true,
  live_session_id: 'l',
  live_state: 'streaming',
  trend: [],
  trend_days: [],
  trend_low: [],
  trend_high: [],
  due: '',
  action: 'watch',
  action_session_id: 'l',
} as unknown as CaseloadRow;

it('says on the caseload what hurt and when, in her words, beside that she exercises now, and marks it', async () => {
  const { asked } = renderPage(<CaseloadPage />, {
    answers: { '/api/caseload': [row], 'POST /api/patients/p/worries/seen': [] },
  });
  const line = within((await screen.findAllByRole('row'))[1] as HTMLElement);
  expect(line.getByText('Pain')).toBeTruthy();
  expect(line.getByText('Live now')).toBeTruthy();
  expect(line.getByText('Es zog in der Schulter').tagName).toBe('Q');
  expect(line.getByText(/pain 6 of 10/)).toBeTruthy();
  expect(line.getByRole('link', { name: /20 Nov/ })).toHaveProperty('pathname', '/sessions/s');
  expect(line.getByRole('link', { name: '2 more not seen yet' })).toHaveProperty('pathname', '/patients/p');
  await userEvent.click(line.getByRole('button', { name: 'Mark as seen: Pain, Amara Okafor' }));
  await waitFor(() => expect(asked.find((one) => one.method === 'POST')?.body).toEqual({ worries: [named] }));
});

it('offers no mark to who may only read, and shows a worry beside a more urgent reason', async () => {
  const other = worry({ kind: 'compensation', text: 'Trunk: 9° more.', words: '' });
  renderPage(<CaseloadPage />, {
    answers: {
      '/api/caseload': [{ ...row, reason: 'declining', reason_text: 'It fell.', worry: other, may_treat: false }],
    },
  });
  const line = within((await screen.findAllByRole('row'))[1] as HTMLElement);
  for (const words of ['Declining', 'It fell.', 'Compensation', 'Trunk: 9° more.'])
    expect(line.getByText(words)).toBeTruthy();
  expect(line.queryByRole('button')).toBeNull();
});

it('lists on the patient’s page what nobody has seen, and who has seen what', async () => {
  const seen = worry({ session_id: 'a', kind: 'stop', seen_at: '2026-11-21T09:00:00Z', seen_by: 'I. Solberg' });
  const { asked } = renderPage(<WorryPanel patient={{ id: 'p', may_treat: true } as Patient} />, {
    answers: {
      '/api/patients/p/worries': [worry({}), worry({ session_id: 't', kind: 'link_lost', words: '' }), seen],
      'POST /api/patients/p/worries/seen': [],
    },
  });
  expect(await screen.findByRole('heading', { name: 'Not seen yet' })).toBeTruthy();
  expect(screen.getByText(/^Seen by I. Solberg, 21 Nov/)).toBeTruthy();
  await userEvent.click(screen.getByRole('button', { name: 'Mark all 2 as seen' }));
  await waitFor(() =>
    expect((asked.find((one) => one.method === 'POST')?.body as { worries: [] }).worries).toHaveLength(2),
  );
});
