import { screen, waitFor, within } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { afterEach, describe, expect, it, vi } from 'vitest';
import type { CaseloadRow, SensorHealth } from '../../src/api/types';
import { CaseloadPage } from '../../src/pages/Caseload';
import { HealthPanel } from '../../src/pages/session/live/HealthPanel';
import { stepOf } from '../../src/pages/session/live/StateSteps';
import { SignInPage } from '../../src/pages/SignIn';
import { renderPage, THERAPIST } from './render';

afterEach(() => vi.unstubAllGlobals());

const row = (change: Partial<CaseloadRow>): CaseloadRow => ({
  patient_id: 'p',
  given_name: 'Amara',
  family_name: 'Okafor',
  affected_side: 'right',
  due: 'Reaching, 3 times a week',
  last_session_at: null,
  worry: null,
  worry_count: 0,
  may_treat: true,
  trend_days: ['2026-11-01', '2026-11-08'],
  live_session_id: null,
  live_state: null,
  main_measure: 'Elbow flexion, range of motion',
  main_unit: 'deg',
  trend: [50, 58],
  trend_low: [48, 56],
  trend_high: [52, 60],
  adherence_percent: 54,
  reason: '',
  reason_text: '',
  action: 'open',
  action_session_id: null,
  ...change,
});

describe('caseload', () => {
  it('says in one line a patient who, why, how it goes and what is due', async () => {
    renderPage(<CaseloadPage />, {
      answers: {
        '/api/caseload': [
          row({
            patient_id: 'q',
            given_name: 'Tomasz',
            family_name: 'Lind',
            affected_side: 'left',
            reason: 'declining',
            reason_text: 'The range fell.',
            action: 'progress',
          }),
          row({}),
          row({
            patient_id: 'r',
            given_name: 'Noor',
            live_session_id: 's',
            live_state: 'streaming',
            action: 'watch',
            action_session_id: 's',
          }),
        ],
      },
    });
    const lines = (await screen.findAllByRole('row')).slice(1);
    expect(lines).toHaveLength(3);
    const first = within(lines[0] as HTMLElement);
    expect(first.getByRole('link', { name: 'Tomasz Lind' })).toHaveProperty('pathname', '/patients/q');
    expect(first.getByText('Declining')).toBeTruthy();
    expect(first.getByRole('link', { name: 'See progress: Tomasz Lind' })).toHaveProperty('pathname', '/patients/q');
    // The patient's name leads to the patient; beside it a line offers one thing to do.
    for (const line of lines) expect(within(line).getAllByRole('link')).toHaveLength(2);
    expect(first.getByText('Left side affected')).toBeTruthy();
    expect(first.getByRole('img').getAttribute('aria-label')).toMatch(/2 days, from 50° to 58°/);
    // Who exercises now has a line and a filter of their own: the sentence and the filter count the same people.
    expect(screen.getByText('1 patient needs attention')).toBeTruthy();
    expect(screen.getByText('Need attention (1)')).toBeTruthy();
  });

  it('never calls a dead link live, and hides no worry behind an open session', async () => {
    const open = { live_session_id: 's', reason_text: '' } as const;
    renderPage(<CaseloadPage />, {
      answers: {
        '/api/caseload': [
          row({ ...open, patient_id: 'a', reason: 'declining', live_state: 'link_lost' }),
          row({ ...open, patient_id: 'b', reason: 'declining', live_state: 'streaming' }),
          row({ ...open, patient_id: 'c', reason: 'link_lost', live_state: 'link_lost' }),
        ],
      },
    });
    const lines = (await screen.findAllByRole('row'))
      .slice(1)
      .map((line) => (line.children[1] as HTMLElement).textContent);
    expect(lines).toEqual(['DecliningSignal lost', 'DecliningLive now', 'Signal lost']);
  });

  it('tells in a demonstration how far its past sessions are, and elsewhere nothing', async () => {
    const demonstration = renderPage(<CaseloadPage />, {
      answers: { '/api/caseload': [row({})], '/api/demonstration': { prepared: 4, total: 15 } },
    });
    expect(await screen.findByText('Preparing past sessions: 4 of 15')).toBeTruthy();
    demonstration.unmount();
    renderPage(<CaseloadPage />, { answers: { '/api/caseload': [row({})] } });
    await screen.findAllByRole('row');
    expect(screen.queryByText(/Preparing past sessions/)).toBeNull();
  });

  it('says what to do when there is nobody yet', async () => {
    renderPage(<CaseloadPage />, { answers: { '/api/caseload': [] } });
    expect(await screen.findByRole('heading', { name: 'No patients yet' })).toBeTruthy();
    expect(screen.getAllByRole('link', { name: 'Add patient' }).length).toBeGreaterThan(0);
  });

  it('shows the service’s own words when it fails', async () => {
    renderPage(<CaseloadPage />, {
      answers: {
        '/api/caseload': [503, { code: 'unavailable', message: 'The service is shutting down.', details: {} }],
      },
    });
    expect((await screen.findByRole('alert')).textContent).toMatch(/shutting down.*works again/);
  });
});

describe('signing in', () => {
  const fill = async () => {
    await userEvent.type(await screen.findByLabelText('E-mail'), 'i@example.org');
    await userEvent.type(screen.getByLabelText('Password'), 'secret words');
    await userEvent.click(screen.getByRole('button', { name: 'Sign in' }));
  };
  const nobody = [401, { code: 'sign_in_required', message: 'Sign in.', details: {} }];

  it('goes back to the page that was asked for', async () => {
    const { router, asked } = renderPage(<SignInPage />, {
      path: '/sign-in',
      at: '/sign-in?next=%2Fpatients%2Fp',
      answers: { '/api/me': nobody, 'POST /api/sign-in': THERAPIST },
    });
    await fill();
    await waitFor(() => expect(router.state.location.pathname).toBe('/patients/p'));
    expect(asked.at(-1)?.body).toEqual({ email: 'i@example.org', password: 'secret words', code: null });
  });

  it('never follows an address of another site', async () => {
    const { router } = renderPage(<SignInPage />, {
      path: '/sign-in',
      at: '/sign-in?next=%2F%2Fevil.example',
      answers: { '/api/me': nobody, 'POST /api/sign-in': THERAPIST },
    });
    await fill();
    await waitFor(() => expect(router.state.location.pathname).toBe('/'));
  });

  it('says why it did not work', async () => {
    renderPage(<SignInPage />, {
      path: '/sign-in',
      at: '/sign-in',
      answers: {
        '/api/me': nobody,
        'POST /api/sign-in': [401, { code: 'sign_in_required', message: 'E-mail or password is wrong.', details: {} }],
      },
    });
    await fill();
    expect((await screen.findByRole('alert')).textContent).toMatch(/E-mail or password is wrong/);
  });
});

describe('sensor health', () => {
  const sensor = (placement: string, change: Partial<SensorHealth> = {}): SensorHealth => ({
    placement,
    status: 'ok',
    loss_percent: 0.2,
    jitter_ms: 3,
    saturated: false,
    magnetic_disturbance: false,
    heading_trusted: true,
    battery_percent: null,
    ...change,
  });
  const show = (sensors: SensorHealth[]) => {
    const health = {
      type: 'health' as const,
      sensors,
      packets_stored: 1,
      packets_received: 1,
      packets_missing: 0,
      is_being_stored: true,
      latency_ms_median: 1,
      latency_ms_p99: 2,
      clock_skew_ppm: null,
    };
    renderPage(<HealthPanel health={health} placements={[]} />, { answers: {} });
    return screen.getByRole('region', { name: 'Sensors' });
  };

  it('is quiet while all is well', () => {
    const panel = show([sensor('sternum'), sensor('forearm_left')]);
    expect(within(panel).getAllByText('Good')).toHaveLength(2);
  });
  it('names the sensor and the trouble', () => {
    const panel = show([sensor('sternum'), sensor('forearm_left', { status: 'lost' })]);
    expect(panel.textContent).toMatch(/Left forearm.*Signal lost/);
    expect(within(panel).getByRole('status').textContent).toBe('Signal lost: left forearm');
  });
  it('says once what all sensors have', () => {
    const panel = show([
      sensor('sternum', { jitter_ms: 90 }),
      sensor('forearm_left', { jitter_ms: 90, magnetic_disturbance: true }),
    ]);
    expect(within(panel).getAllByText(/Uneven timing/)).toHaveLength(1);
    expect(within(panel).getByText('Metal or magnet nearby')).toBeTruthy();
  });
});

describe('steps of a session', () => {
  it('stay where they were while the link is lost', () => {
    expect(stepOf('recording', 0, { isCalibrated: true, isRecording: true })).toBe(3);
    expect(stepOf('link_lost', 3, { isCalibrated: true, isRecording: false })).toBe(3);
    expect(stepOf('link_lost', 0, { isCalibrated: true, isRecording: true })).toBe(3);
    expect(stepOf('link_lost', 0, { isCalibrated: false, isRecording: false })).toBe(1);
  });
});
