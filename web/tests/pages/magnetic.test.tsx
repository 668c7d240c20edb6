import { screen, within } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { afterEach, expect, it, vi } from 'vitest';
import type { MagneticSafety, SessionDetail } from '../../src/api/types';
import { PulseTimeline } from '../../src/pages/magnetic/PulseTimeline';
import { SafetyCard } from '../../src/pages/magnetic/SafetyCard';
import { renderPage } from './render';

afterEach(() => vi.unstubAllGlobals());

const SAFETY: MagneticSafety = {
  required: true,
  confirmed: false,
  confirmed_at: null,
  confirmed_by: null,
  source: 'pelvis',
  keep_away_m: 0.16,
  limit_t: 5e-4,
  warning: '',
};
const session = (may_treat: boolean) => ({ id: 's', may_treat }) as unknown as SessionDetail;

it('asks both questions before it lets a therapist confirm', async () => {
  const { asked } = renderPage(<SafetyCard session={session(true)} />, {
    answers: { '/api/sessions/s/magnetic-safety': SAFETY, 'POST /api/sessions/s/magnetic-safety': { ...SAFETY, confirmed: true } },
  });
  expect(await screen.findByText(/pacemaker, an implanted/)).toBeTruthy();
  expect(screen.getByText(/Closer than 16 cm/)).toBeTruthy();
  const button = screen.getByRole('button', { name: 'Confirm for this session' });
  const answer = (question: RegExp, name: string) => userEvent.click(within(screen.getByRole('group', { name: question })).getByLabelText(name));
  expect(button).toHaveProperty('disabled', true);
  await answer(/Ask the patient/, 'No');
  expect(button).toHaveProperty('disabled', true);
  await answer(/everybody who will be near/, 'Yes, or not sure');
  expect(button).toHaveProperty('disabled', true);
  expect(screen.getByRole('alert').textContent).toMatch(/Do not use the source/);
  await answer(/everybody who will be near/, 'No');
  await userEvent.click(button);
  expect(asked.find((one) => one.method === 'POST')?.body).toEqual({ patient_has_no_implant: true, people_nearby_have_none: true });
});

it('lets nobody else confirm', async () => {
  renderPage(<SafetyCard session={session(false)} />, { answers: { '/api/sessions/s/magnetic-safety': SAFETY } });
  expect(await screen.findByText(/A therapist must confirm/)).toBeTruthy();
  expect(screen.queryByRole('button')).toBeNull();
});

it('says who confirmed', async () => {
  renderPage(<SafetyCard session={session(true)} />, {
    answers: { '/api/sessions/s/magnetic-safety': { ...SAFETY, confirmed: true, confirmed_by: 'Ingrid Solberg', confirmed_at: '2026-11-21T10:00:00Z' } },
  });
  expect(await screen.findByText(/confirmed by Ingrid Solberg/)).toBeTruthy();
});

it('draws the pulses of the time shown, and says how many', () => {
  const pulses = [
    { coil: 1, startS: 1, endS: 1.08, currentA: 1.3 },
    { coil: 3, startS: 2, endS: 2.03, currentA: 1.3 },
    { coil: 2, startS: 30, endS: 30.1, currentA: 1.3 },
  ];
  renderPage(<PulseTimeline pulses={pulses} fromS={0} untilS={20} nowS={5} />, { answers: {} });
  expect(screen.getByRole('img', { name: /20 s: 2 pulses/ }).querySelectorAll('rect')).toHaveLength(2);
});
