import { screen, waitFor, within } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { afterEach, expect, it, vi } from 'vitest';
import type { Account, Me, Patient } from '../../src/api/types';
import { SecondFactorRemoved } from '../../src/components/account/SecondFactorRemoved';
import { ClinicPage } from '../../src/pages/Clinic';
import { DataPanel } from '../../src/pages/patient/DataPanel';
import { renderPage, THERAPIST } from './render';

afterEach(() => vi.unstubAllGlobals());

const ADMIN: Me = { ...THERAPIST, account_id: 'admin', role: 'administrator' };
const account = (id: string, change: Partial<Account> = {}): Account => ({
  id,
  display_name: `Person ${id}`,
  email: `${id}@e.example`,
  role: 'therapist',
  is_active: true,
  ...change,
});
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
  may_treat: false,
  may_manage: true,
  ...change,
});

it('switches an account off, but never the own one', async () => {
  const { asked } = renderPage(<ClinicPage />, {
    me: ADMIN,
    answers: {
      '/api/accounts': [account('a'), account('admin', { role: 'administrator' })],
      'PATCH /api/accounts/a': account('a', { is_active: false }),
    },
  });
  const off = await screen.findByRole('switch');
  expect(screen.getAllByRole('switch')).toHaveLength(1);
  await userEvent.click(off);
  await waitFor(() => expect(asked.some((one) => one.method === 'PATCH')).toBe(true));
  expect(asked.find((one) => one.method === 'PATCH')).toMatchObject({
    path: '/api/accounts/a',
    body: { is_active: false },
  });
});

it('removes the second factor of who lost the device, after asking', async () => {
  const answers = {
    '/api/accounts': [account('a', { has_second_factor: true }), account('b', { has_second_factor: false })],
    'PATCH /api/accounts/a': account('a', { has_second_factor: false }),
  };
  const { asked } = renderPage(<ClinicPage />, { me: ADMIN, answers });
  const buttons = await screen.findAllByRole('button', { name: /^Turn off two-step sign-in of/ });
  expect(buttons.map((one) => one.getAttribute('aria-label'))).toEqual(['Turn off two-step sign-in of Person a']);
  await userEvent.click(buttons[0] as HTMLElement);
  const dialog = within(await screen.findByRole('dialog'));
  expect(dialog.getByText(/signed out everywhere/)).toBeTruthy();
  expect(asked.some((one) => one.method === 'PATCH')).toBe(false);
  await userEvent.click(dialog.getByRole('button', { name: 'Turn off two-step sign-in' }));
  await waitFor(() =>
    expect(asked.find((one) => one.method === 'PATCH')).toMatchObject({
      path: '/api/accounts/a',
      body: { remove_second_factor: true },
    }),
  );
});

it('shows a therapist neither the button nor the time zone', async () => {
  renderPage(<ClinicPage />, {
    answers: {
      '/api/accounts': [account('a', { has_second_factor: null })],
      '/api/clinic': { name: 'C', time_zone: 'UTC', is_time_zone_set: false },
    },
  });
  await screen.findByText('Person a');
  expect(screen.queryByRole('button', { name: /two-step/ })).toBeNull();
  expect(screen.queryByRole('heading', { name: 'Time zone' })).toBeNull();
});

it('lets an administrator choose the time zone of the clinic', async () => {
  const { asked } = renderPage(<ClinicPage />, {
    me: ADMIN,
    answers: {
      '/api/accounts': [],
      '/api/clinic': { name: 'C', time_zone: 'UTC', is_time_zone_set: false },
      'PATCH /api/clinic': { name: 'C', time_zone: 'Europe/Oslo', is_time_zone_set: true },
    },
  });
  expect(await screen.findByText(/Not chosen yet/)).toBeTruthy();
  const field = screen.getByRole('combobox', { name: 'Time zone of the clinic' });
  await userEvent.click(field);
  await userEvent.clear(field);
  await userEvent.type(field, 'Oslo');
  await userEvent.click(await screen.findByRole('option', { name: 'Europe/Oslo', hidden: true }));
  await waitFor(() =>
    expect(asked.find((one) => one.method === 'PATCH')).toMatchObject({
      path: '/api/clinic',
      body: { time_zone: 'Europe/Oslo' },
    }),
  );
  expect(await screen.findByText(/^Saved/)).toBeTruthy();
});

it('tells who signs in that an administrator turned the second factor off, until it is read', async () => {
  const { asked } = renderPage(<SecondFactorRemoved at="2026-11-20T09:00:00Z" />, {
    answers: { 'POST /api/me/second-factor/noted': {} },
  });
  expect(screen.getByText(/administrator of your clinic turned off two-step sign-in .* on 20 Nov/)).toBeTruthy();
  expect(screen.getByRole('link', { name: 'Set it up again' }).getAttribute('href')).toBe('/account');
  await userEvent.click(screen.getByRole('button', { name: 'Understood' }));
  await waitFor(() =>
    expect(asked.some((one) => one.path === '/api/me/second-factor/noted' && one.method === 'POST')).toBe(true),
  );
});

it('lists measured sources, takes one from a file and no longer offers one', async () => {
  const source = {
    id: 'm',
    name: 'Belt',
    serial: 'S-1',
    gain_sigma: 0.004,
    method: 'session',
    calibrated_at: '2026-11-01T10:00:00Z',
  };
  const { asked, container } = renderPage(<ClinicPage />, {
    me: ADMIN,
    answers: {
      '/api/accounts': [],
      '/api/magnetic-sources': [source],
      'POST /api/magnetic-sources': source,
      'DELETE /api/magnetic-sources/m': {},
    },
  });
  expect(await screen.findByText(/Serial number S-1. Field uncertainty 0.4 %, measured on a bench/)).toBeTruthy();
  const input = container.querySelector<HTMLInputElement>('input[type=file]');
  if (!input) throw new Error('no file input');
  await userEvent.upload(
    input,
    new File([JSON.stringify({ name: 'Belt', coils: [] })], 'b.json', { type: 'application/json' }),
  );
  await waitFor(() => expect(asked.find((one) => one.method === 'POST')?.body).toEqual({ name: 'Belt', coils: [] }));
  await userEvent.click(screen.getByRole('button', { name: 'No longer offer: Belt' }));
  await userEvent.click(within(await screen.findByRole('dialog')).getByRole('button', { name: 'No longer offer' }));
  await waitFor(() => expect(asked.at(-2)?.method === 'DELETE' || asked.at(-1)?.method === 'DELETE').toBe(true));
});

it('refuses a file that is no source', async () => {
  const { asked, container } = renderPage(<ClinicPage />, {
    me: ADMIN,
    answers: { '/api/accounts': [], '/api/magnetic-sources': [] },
  });
  expect(await screen.findByText(/No source has been measured yet/)).toBeTruthy();
  const input = container.querySelector<HTMLInputElement>('input[type=file]');
  if (!input) throw new Error('no file input');
  await userEvent.upload(input, new File(['[1]'], 'a.json', { type: 'application/json' }));
  expect(await screen.findByText(/This file is not a source/)).toBeTruthy();
  expect(asked.some((one) => one.method === 'POST')).toBe(false);
});

it('erases only what is archived, and only after the name was typed', async () => {
  const first = renderPage(<DataPanel patient={patient()} />, { me: ADMIN, answers: {} });
  expect(screen.queryByRole('button', { name: 'Erase permanently' })).toBeNull();
  first.unmount();
  const { asked } = renderPage(<DataPanel patient={patient({ archived_at: '2026-01-01T00:00:00Z' })} />, {
    me: ADMIN,
    answers: { 'DELETE /api/patients/p': {} },
  });
  await userEvent.click(screen.getByRole('button', { name: 'Erase permanently' }));
  const dialog = within(await screen.findByRole('dialog'));
  const erase = dialog.getByRole('button', { name: 'Erase permanently' });
  expect(erase).toHaveProperty('disabled', true);
  await userEvent.type(dialog.getByRole('textbox'), 'Berg');
  await userEvent.click(erase);
  await waitFor(() =>
    expect(asked.at(-1)).toMatchObject({ method: 'DELETE', path: '/api/patients/p', body: { confirmation: 'ERASE' } }),
  );
});

it('lets a therapist download and archive, not erase', () => {
  renderPage(<DataPanel patient={patient({ may_treat: true, archived_at: '2026-01-01T00:00:00Z' })} />, {
    answers: {},
  });
  expect(screen.getByRole('link', { name: 'Download everything' }).getAttribute('href')).toBe('/api/patients/p/export');
  expect(screen.queryByRole('button', { name: 'Erase permanently' })).toBeNull();
});
