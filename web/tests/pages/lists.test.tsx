// Lists that come in pages: read on when somebody asks, and by themselves where every row counts.
import { screen, waitFor, within } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { describe, expect, it } from 'vitest';
import { address } from '../../src/api/address';
import { api } from '../../src/api/client';
import type { Patient } from '../../src/api/types';
import { CaseloadPage } from '../../src/pages/Caseload';
import { SessionPanel } from '../../src/pages/patient/SessionPanel';
import { Paged, renderPage } from './render';

const PATIENT = { id: 'p' } as Patient;
const session = (number: number) => ({
  id: `s${number}`,
  patient_id: PATIENT.id,
  exercise_name: `Exercise ${number}`,
  purpose: 'exercise',
  source: 'upload',
  state: 'analysed',
  created_at: '2026-03-01T09:00:00Z',
  started_at: null,
  duration_s: 60,
  packets_stored: 0,
  packets_missing: 0,
});
const sessions = (from: number, count: number) => Array.from({ length: count }, (_, index) => session(from + index));
const row = (name: string, reason = '') => ({
  patient_id: name,
  given_name: name,
  family_name: 'Lund',
  affected_side: null,
  due: '',
  trend: [],
  trend_low: [],
  trend_high: [],
  adherence_percent: null,
  reason,
  reason_text: '',
  action: 'open',
  action_session_id: null,
  live_session_id: null,
  live_state: null,
});
const CASELOAD = '/api/caseload';
const NEXT = '/api/caseload?limit=50&after=x';

describe('lists in pages', () => {
  it('shows the older sessions of a patient on request', async () => {
    const path = `/api/patients/${PATIENT.id}/sessions`;
    renderPage(<SessionPanel patient={PATIENT} />, {
      answers: {
        [path]: new Paged(sessions(0, 50), `${path}?after=x`),
        [`${path}?after=x`]: sessions(50, 3),
        [`/api/patients/${PATIENT.id}/walks`]: [],
      },
    });
    await screen.findByText('Exercise 0');
    expect(screen.getAllByRole('listitem')).toHaveLength(8);
    await userEvent.click(screen.getByRole('button', { name: 'Show more' }));
    expect(screen.getAllByRole('listitem')).toHaveLength(50);
    await userEvent.click(screen.getByRole('button', { name: 'Show more' }));
    await screen.findByText('Exercise 52');
    expect(screen.getAllByRole('listitem')).toHaveLength(53);
    expect(screen.queryByRole('button', { name: 'Show more' })).toBeNull();
  });

  it('says when a further page could not be read, and tries again', async () => {
    const path = `/api/patients/${PATIENT.id}/sessions`;
    renderPage(<SessionPanel patient={PATIENT} />, {
      answers: { [path]: new Paged(sessions(0, 9), `${path}?after=x`), [`/api/patients/${PATIENT.id}/walks`]: [] },
    });
    await screen.findByText('Exercise 0');
    await userEvent.click(screen.getByRole('button', { name: 'Show more' }));
    await userEvent.click(screen.getByRole('button', { name: 'Show more' }));
    expect(await screen.findByRole('alert')).toBeTruthy();
    expect(screen.getByText('Exercise 8')).toBeTruthy();
  });

  it('finds a patient who is on no page that was read', async () => {
    const { asked } = renderPage(<CaseloadPage />, {
      answers: { [CASELOAD]: new Paged([row('Ada')], NEXT), [NEXT]: [row('Zoe')], '/api/demonstration': null },
    });
    await screen.findByText('Ada Lund');
    expect(asked.some((one) => one.path === NEXT)).toBe(false);
    expect(screen.getByText('All (1+)')).toBeTruthy();
    await userEvent.type(screen.getByRole('textbox'), 'zoe');
    await screen.findByText('Zoe Lund');
    expect(screen.getByText('All (2)')).toBeTruthy();
  });

  it('counts everybody who needs attention', async () => {
    renderPage(<CaseloadPage />, {
      answers: {
        [CASELOAD]: new Paged([row('Ada', 'declining')], NEXT),
        [NEXT]: [row('Bea', 'bad_data'), row('Zoe')],
        '/api/demonstration': null,
      },
    });
    await screen.findByText('2 patients need attention');
    const table = screen.getByRole('table');
    await waitFor(() => expect(within(table).getAllByRole('row')).toHaveLength(4));
  });

  it('follows a list to its end where every row is needed', async () => {
    renderPage(<p />, {
      answers: { '/api/accounts': new Paged(['a', 'b'], '/b'), '/b': new Paged(['c'], '/c'), '/c': ['d'] },
    });
    expect(await api.all(address('/api/accounts'))).toEqual(['a', 'b', 'c', 'd']);
  });
});
