import { MantineProvider } from '@mantine/core';
import { render, screen, waitFor, within } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { afterEach, describe, expect, it, vi } from 'vitest';
import { ApiError } from '../../../src/api/client';
import type { Me, Patient } from '../../../src/api/types';
import { Problem } from '../../../src/components/Feedback';
import { CaseloadPage } from '../../../src/pages/Caseload';
import { MyDataPage } from '../../../src/pages/mine/MyData';
import { PatientNewPage } from '../../../src/pages/PatientNew';
import { PatientPage } from '../../../src/pages/patient/PatientPage';
import { renderPage, THERAPIST } from '../render';

afterEach(() => vi.unstubAllGlobals());

const OWN: Me = { ...THERAPIST, role: 'patient', display_name: 'Ada Berg', patient_id: 'p' };
const patient = (change: Partial<Patient> = {}): Patient => ({
  id: 'p',
  given_name: 'Ada',
  family_name: 'Berg',
  birth_date: null,
  affected_side: null,
  notes: '',
  body_dimensions: {},
  created_at: '',
  archived_at: null,
  has_mounting: false,
  may_treat: true,
  may_manage: true,
  ...change,
});
const answersOf = (one: Patient) => ({
  '/api/patients/p': one,
  '/api/patients/p/consents': [{ purpose: 'treatment', granted: true, changed_at: '2026-01-05T10:00:00Z' }],
  '/api/patients/p/device-tokens': [],
  '/api/patients/p/grants': [
    { id: 'g', account_id: 'b', display_name: 'Jonas Weber', level: 'read', expires_at: null, created_at: '' },
  ],
  '/api/patients/p/progress': { exercise_id: null, measures: [], events: [] },
  '/api/patients/p/prescriptions': [
    {
      id: 'x',
      exercise_id: 'e',
      exercise_name: 'Reach',
      template_id: null,
      template_name: null,
      repetitions: 8,
      sets: 1,
      times_per_week: 3,
      days: [1, 3, 5],
      times: ['09:00'],
      tolerance_scale: 1.5,
      stops: [],
      is_due_today: true,
      done_today: 0,
      starts_at: '',
      ends_at: null,
      done_this_week: 0,
    },
  ],
  '/api/patients/p/sessions': [],
  '/api/patients/p/walks': [],
  '/api/exercises': [],
});
const open = (one: Patient) =>
  renderPage(<PatientPage />, {
    path: '/patients/:patientId',
    at: '/patients/p',
    answers: { ...answersOf(one), 'PUT /api/patients/p/consents': [] },
  });

describe('a refusal', () => {
  it('advises to ask for a right only where a right is missing', () => {
    const advice = /Ask an administrator of your clinic/;
    const { rerender } = render(
      <Problem error={new ApiError(403, 'not_allowed', 'It needs the right to treat.', { level: 'treat' })} />,
      { wrapper: MantineProvider },
    );
    expect(screen.getByText(advice)).toBeTruthy();
    for (const details of [{ purpose: 'treatment' }, { archived: true }]) {
      rerender(<Problem error={new ApiError(403, 'not_allowed', 'Not now.', details)} />);
      expect(screen.queryByText(advice)).toBeNull();
    }
  });
});

describe('a prescription', () => {
  const given = answersOf(patient())['/api/patients/p/prescriptions'][0];
  const week = { done_this_week: 13, repetitions_this_week: 130, active_s_this_week: 1320, is_twice: false };
  const shown = (change: object) =>
    renderPage(<PatientPage />, {
      path: '/patients/:patientId',
      at: '/patients/p',
      answers: {
        ...answersOf(patient()),
        '/api/exercises': [{ id: 'e', name: 'Reach', movement: 'reaching' }],
        '/api/patients/p/prescriptions': [{ ...given, ...week, ...change }],
      },
    });

  it('says what was done this week, and never more sessions than prescribed', async () => {
    shown({});
    expect(
      await screen.findByText('3 of 3 sessions this week · 10 more than prescribed · 130 repetitions · 22 min active'),
    ).toBeTruthy();
    expect(screen.queryByText(/Prescribed twice/)).toBeNull();
  });

  it('says when the exercise is prescribed twice, in the list and before it is', async () => {
    shown({ is_twice: true });
    expect(await screen.findByText(/Prescribed twice. A session counts once/)).toBeTruthy();
    await userEvent.click(screen.getByRole('button', { name: 'Prescribe' }));
    const dialog = within(await screen.findByRole('dialog'));
    expect(dialog.queryByText(/prescribed already/)).toBeNull();
    await userEvent.click(dialog.getByRole('combobox', { name: 'Exercise' }));
    await userEvent.click(await screen.findByRole('option', { name: 'Reach', hidden: true }));
    expect(await dialog.findByText(/prescribed already. A session counts for one of the two only/)).toBeTruthy();
  });
});

describe('consent', () => {
  it('is asked for on the patient’s page, where the refusal sends people', async () => {
    const { asked } = open(patient());
    const home = await screen.findByRole('radiogroup', { name: 'Exercising at home' });
    expect(home.parentElement?.textContent).toMatch(/Not asked yet/);
    expect(within(home).queryAllByRole('radio', { checked: true })).toHaveLength(0);
    await userEvent.click(within(home).getByRole('radio', { name: 'Yes' }));
    await waitFor(() =>
      expect(asked.find((one) => one.method === 'PUT')?.body).toEqual({ purpose: 'home_streaming', granted: true }),
    );
  });

  it('is asked for when a patient is added, and never ticked before', async () => {
    const { asked } = renderPage(<PatientNewPage />, { answers: { 'POST /api/patients': patient() } });
    await userEvent.type(await screen.findByLabelText('Given name'), 'Ada');
    await userEvent.type(screen.getByLabelText('Family name'), 'Berg');
    const tick = screen.getByRole('checkbox', { name: 'The patient agrees to treatment' });
    expect(tick).toHaveProperty('checked', false);
    await userEvent.click(tick);
    await userEvent.click(screen.getByRole('button', { name: 'Save' }));
    await waitFor(() =>
      expect(asked.find((one) => one.method === 'POST')?.body).toMatchObject({
        given_name: 'Ada',
        agrees_to_treatment: true,
      }),
    );
  });

  it('is the patient’s own to give and to take back', async () => {
    const { asked } = renderPage(<MyDataPage />, {
      me: OWN,
      answers: {
        '/api/patients/p/consents': [{ purpose: 'research', granted: true, changed_at: '2026-01-05T10:00:00Z' }],
        '/api/patients/p/grants': [],
        '/api/patients/p/audit': [],
        'PUT /api/patients/p/consents': [],
      },
    });
    const research = await screen.findByRole('radiogroup', { name: 'Research' });
    expect(within(research).getByRole('radio', { name: 'Yes' })).toHaveProperty('checked', true);
    await userEvent.click(within(research).getByRole('radio', { name: 'No' }));
    await waitFor(() =>
      expect(asked.find((one) => one.method === 'PUT')?.body).toEqual({ purpose: 'research', granted: false }),
    );
  });
});

describe('an archived patient', () => {
  it('is found again under the filter Archived', async () => {
    renderPage(<CaseloadPage />, {
      answers: {
        '/api/caseload': [],
        '/api/patients?archived=true': [patient({ archived_at: '2026-02-01T10:00:00Z' })],
      },
    });
    await userEvent.click(await screen.findByRole('button', { name: 'Show archived patients' }));
    expect((await screen.findByRole('link', { name: 'Ada Berg' })).getAttribute('href')).toBe('/patients/p');
  });

  it('offers nothing that would be refused, only reading, taking along and restoring', async () => {
    open(patient({ archived_at: '2026-02-01T10:00:00Z', may_treat: false }));
    expect(await screen.findByRole('button', { name: 'Restore from the archive' })).toBeTruthy();
    await screen.findByText('Jonas Weber');
    const offered = [...screen.getAllByRole('button'), ...screen.getAllByRole('link')].map((one) => one.textContent);
    for (const refused of [
      'New session',
      'Upload',
      'Prescribe',
      'Share',
      'Add',
      'Edit',
      'Archive',
      'Record a template',
      'End',
    ])
      expect(offered).not.toContain(refused);
    for (const radio of await screen.findAllByRole('radio')) expect(radio).toHaveProperty('disabled', true);
  });
});
