import { screen, waitFor, within } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { afterEach, expect, it, vi } from 'vitest';
import type { MagneticSafety, SessionDetail } from '../../../src/api/types';
import type { Player } from '../../../src/player/types';
import { BenchPanel } from '../../../src/kinds/magnetic/BenchPanel';
import { LiveSource } from '../../../src/kinds/magnetic/LiveSource';
import { PulseTimeline } from '../../../src/kinds/magnetic/PulseTimeline';
import { SafetyCard } from '../../../src/kinds/magnetic/SafetyCard';
import { renderPage } from '../render';

afterEach(() => vi.unstubAllGlobals());

const SAFETY: MagneticSafety = {
  required: true,
  confirmed: false,
  confirmed_at: null,
  confirmed_by: null,
  expires_at: null,
  withdrawn_at: null,
  withdrawn_by: null,
  source_name: '',
  source_serial: '',
  calibrated_on: '',
  gain_sigma: 0.03,
  source: 'pelvis',
  keep_away_m: 0.16,
  limit_t: 5e-4,
  warning: '',
};
const session = (may_treat: boolean) => ({ id: 's', may_treat, state: 'ready' }) as unknown as SessionDetail;

it('asks both questions before it lets a therapist confirm', async () => {
  const { asked } = renderPage(<SafetyCard session={session(true)} />, {
    answers: {
      '/api/sessions/s/magnetic-safety': SAFETY,
      'POST /api/sessions/s/magnetic-safety': { ...SAFETY, confirmed: true },
    },
  });
  expect(await screen.findByText(/pacemaker, an implanted/)).toBeTruthy();
  expect(screen.getByText(/Closer than 16 cm/)).toBeTruthy();
  const button = screen.getByRole('button', { name: 'Confirm for this session' });
  const answer = (question: RegExp, name: string) =>
    userEvent.click(within(screen.getByRole('group', { name: question })).getByLabelText(name));
  expect(button).toHaveProperty('disabled', true);
  await answer(/Ask the patient/, 'No');
  expect(button).toHaveProperty('disabled', true);
  await answer(/everybody who will be near/, 'Yes, or not sure');
  expect(button).toHaveProperty('disabled', true);
  expect(screen.getByRole('alert').textContent).toMatch(/Do not use the source/);
  await answer(/everybody who will be near/, 'No');
  await userEvent.click(button);
  expect(asked.find((one) => one.method === 'POST')?.body).toEqual({
    patient_has_no_implant: true,
    people_nearby_have_none: true,
  });
});

it('lets nobody else confirm', async () => {
  renderPage(<SafetyCard session={session(false)} />, { answers: { '/api/sessions/s/magnetic-safety': SAFETY } });
  expect(await screen.findByText(/A therapist must confirm/)).toBeTruthy();
  expect(screen.queryByRole('button')).toBeNull();
});

it('says who confirmed', async () => {
  renderPage(<SafetyCard session={session(true)} />, {
    answers: {
      '/api/sessions/s/magnetic-safety': {
        ...SAFETY,
        confirmed: true,
        confirmed_by: 'Ingrid Solberg',
        confirmed_at: '2026-11-21T10:00:00Z',
      },
    },
  });
  expect(await screen.findByText(/confirmed by Ingrid Solberg/)).toBeTruthy();
});

it('lets the therapist take the word back, and says until when it holds', async () => {
  const confirmed = {
    ...SAFETY,
    confirmed: true,
    confirmed_by: 'Ingrid Solberg',
    confirmed_at: '2026-11-21T10:00:00Z',
    expires_at: '2026-11-21T22:00:00Z',
    source_name: 'Belt',
    source_serial: 'S-1',
    gain_sigma: 0.004,
  };
  const { asked } = renderPage(<SafetyCard session={session(true)} />, {
    answers: { '/api/sessions/s/magnetic-safety': confirmed, 'DELETE /api/sessions/s/magnetic-safety': SAFETY },
  });
  expect(await screen.findByText(/The question is asked again from/)).toBeTruthy();
  expect(screen.getByText(/Source Belt, serial number S-1: field uncertainty 0.4 %/)).toBeTruthy();
  await userEvent.click(screen.getByRole('button', { name: 'Withdraw confirmation' }));
  await userEvent.click(await screen.findByRole('button', { name: 'Stop the source' }));
  await waitFor(() =>
    expect(asked.some((one) => one.method === 'DELETE' && one.path === '/api/sessions/s/magnetic-safety')).toBe(true),
  );
});

it('says why it asks again', async () => {
  const taken = {
    ...SAFETY,
    confirmed_at: '2026-11-21T10:00:00Z',
    withdrawn_at: '2026-11-21T10:05:00Z',
    withdrawn_by: 'Ingrid Solberg',
  };
  renderPage(<SafetyCard session={session(true)} />, { answers: { '/api/sessions/s/magnetic-safety': taken } });
  expect(await screen.findByText(/withdrawn by Ingrid Solberg/)).toBeTruthy();
  expect(screen.getByRole('button', { name: 'Confirm for this session' })).toBeTruthy();
});

it('sends the places of a bench in metres and says what was found', async () => {
  const stop = (n: number) => ({
    start_s: 5 * n,
    end_s: 5 * n + 4,
    pulses: [5, 5, 5],
    strength_t: [1e-6, 1e-6, 1e-6],
    position_m: [0.2, 0.01 * n, 0.06] as [number, number, number],
  });
  const { asked } = renderPage(<BenchPanel sessionId="s" />, {
    answers: {
      '/api/sessions/s/source-stops': { source: 'pelvis', sensor: 'sternum', stops: [0, 1, 2, 3, 4, 5].map(stop) },
      'POST /api/sessions/s/source-calibration': {
        name: 'Belt',
        gain_sigma: 0.0043,
        found: { place_residual_m: 0.0011 },
      },
    },
  });
  await userEvent.click(screen.getByText('Find where the sensor lay still'));
  expect(await screen.findByText(/about 20 \/ 5 \/ 6 cm/)).toBeTruthy();
  const keep = screen.getByRole('button', { name: 'Find the coils and save the source' });
  expect(keep).toHaveProperty('disabled', true);
  for (let row = 1; row <= 6; row += 1)
    for (const axis of ['x', 'y', 'z'])
      await userEvent.type(screen.getByLabelText(`${axis}, stop ${row} (cm)`), `${10 + row}`);
  await userEvent.type(screen.getByLabelText('Name of the source'), 'Belt');
  await userEvent.type(screen.getByLabelText('Serial number'), 'S-1');
  await userEvent.click(keep);
  const sent = asked.find((one) => one.method === 'POST')?.body;
  expect(sent).toMatchObject({ name: 'Belt', serial: 'S-1', place_sigma_m: 0.001 });
  expect((sent as { positions_m: number[][] }).positions_m[1]).toEqual([0.12, 0.12, 0.12]);
  expect(await screen.findByText(/field uncertainty 0.4 %/)).toBeTruthy();
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

it('gives a distance the digits of its uncertainty', async () => {
  const values: Record<string, number> = { sternum_distance_m: 0.3204, sternum_distance_sigma_m: 0.0002 };
  const player = {
    clock: () => ({ timeS: 10, startS: 0, endS: 10, isPlaying: true, speed: 1 }),
    read: (_from: number, _until: number, names: readonly string[]) => ({
      timeS: new Float64Array([10]),
      values: names.map((name) => new Float32Array([values[name] ?? 0])),
      isComplete: true,
    }),
  } as unknown as Player;
  renderPage(<LiveSource player={player} sensors={['sternum']} source="pelvis" />, { answers: {} });
  expect((await screen.findByTestId('distance-sternum')).textContent).toBe('32.04 cm');
  expect(screen.getByText('± 0.04 cm')).toBeTruthy();
});
