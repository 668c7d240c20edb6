import { screen } from '@testing-library/react';
import { expect, it, vi } from 'vitest';
import type {
  Calibration,
  GuidanceMessage,
  HealthMessage,
  Patient,
  SensorHealth,
  SessionDetail,
  SessionEvent,
} from '../../../src/api/types';
import { JointCurves } from '../../../src/kinds/JointCurves';
import type { LiveProps } from '../../../src/kinds/kind';
import { isUnchecked } from '../../../src/lib/calibration';
import { InForce } from '../../../src/pages/calibration/InForce';
import { HealthPanel, SensorLine } from '../../../src/pages/session/live/HealthPanel';
import { AnalysisWait } from '../../../src/pages/session/AnalysisWait';
import { SessionPanel } from '../../../src/pages/patient/SessionPanel';
import { sessionTitle } from '../../../src/lib/sessions';
import { Repetitions } from '../../../src/pages/session/live/Repetitions';
import { renderPage } from '../render';

// jsdom draws no canvas.
vi.mock('../../../src/charts/Plot', async (original) => ({
  ...(await original<object>()),
  Plot: () => null,
}));

const guidance = (change: Partial<GuidanceMessage>) =>
  ({ status: 'moving', cause: '', counts: { valid: 4, partial: 1 }, goal: 6, before: 1, ...change }) as GuidanceMessage;

it('counts large for the therapist, and states no number that is not of now', () => {
  const shown = renderPage(<Repetitions guidance={guidance({})} isKnown />, { answers: {} });
  expect(screen.getByTestId('repetitions').textContent).toBe('4');
  expect(screen.getByText(/5 of 6 today/).textContent).toContain('1 ');
  shown.unmount();
  const lost = renderPage(<Repetitions guidance={guidance({})} isKnown={false} />, { answers: {} });
  expect(screen.getByTestId('repetitions').textContent).toBe('–');
  expect(screen.queryByText(/of 6/)).toBeNull();
  lost.unmount();
  const beyond = renderPage(<Repetitions guidance={guidance({ before: 9 })} isKnown />, { answers: {} });
  expect(screen.getByText(/13 today, goal 6 reached/)).toBeTruthy();
  beyond.unmount();
  renderPage(<Repetitions guidance={guidance({ status: 'off' })} isKnown />, { answers: {} });
  expect(screen.queryByTestId('repetitions')).toBeNull();
});

const sensor = (placement: string, change: Partial<SensorHealth> = {}): SensorHealth => ({
  placement,
  status: 'ok',
  loss_percent: 0,
  jitter_ms: 0,
  saturated: false,
  magnetic_disturbance: false,
  heading_trusted: true,
  ...change,
});
const health = (...sensors: SensorHealth[]) => ({ sensors }) as HealthMessage;

it.each([
  [[sensor('sternum'), sensor('hand_left')], '2 sensors good'],
  [[sensor('sternum'), sensor('hand_left', { magnetic_disturbance: true })], 'Left hand: '],
  // Before it can be known a direction is no alarm; afterwards it is one.
  [[sensor('sternum'), sensor('hand_left', { heading_trusted: false, is_starting: true })], 'Starting'],
  [[sensor('sternum'), sensor('hand_left', { heading_trusted: false })], 'Left hand: Direction unreliable'],
  [
    [sensor('sternum'), sensor('hand_left', { heading_trusted: false, is_starting: true, magnetic_disturbance: true })],
    'Left hand: ',
  ],
  // A lost sensor comes before iron that several meet.
  [
    [
      sensor('sternum', { magnetic_disturbance: true }),
      sensor('forearm_left', { magnetic_disturbance: true }),
      sensor('hand_left', { status: 'lost' }),
    ],
    'Left hand: ',
  ],
  [[sensor('sternum', { status: 'lost' }), sensor('hand_left', { status: 'lost' })], 'All sensors: '],
])('says beside the delay what a sensor needs', (sensors, text) => {
  renderPage(<SensorLine health={health(...sensors)} />, { answers: {} });
  expect(document.querySelector('.live-sensors')?.textContent?.toLowerCase()).toContain(text.toLowerCase());
  expect(document.querySelector('.alert-text') !== null).toBe(sensors.some((one) => one.status === 'lost'));
});

const NOT_CHECKED = { code: 'calibration.not_checked', params: {}, text: 'Not checked by a movement yet: only ...' };
const calibration: Calibration = {
  method: 'n_pose',
  score: 0.9,
  reasons: [NOT_CHECKED.text, 'The left arm hung.'],
  sentences: { reasons: [NOT_CHECKED, 'The left arm hung.'] },
};

it('says once that a pose alone is not checked, and calls it no good calibration', () => {
  renderPage(
    <InForce sessionId="s" calibration={calibration} placements={['upper_arm_left']} onAgain={() => undefined} />,
    { answers: {} },
  );
  expect(screen.getAllByText(/not checked by a movement/i)).toHaveLength(1);
  expect(screen.queryByText(/Good calibration/)).toBeNull();
  expect(screen.getByText('The left arm hung.')).toBeTruthy();
  const event = (text: unknown, kind = 'calibration') => ({ kind, sentences: { text } }) as unknown as SessionEvent;
  expect(isUnchecked(event(NOT_CHECKED))).toBe(true);
  expect(isUnchecked(event({ ...NOT_CHECKED, code: 'calibration.poor' }))).toBe(false);
});

it('shows the legend of the template only while its band is drawn', () => {
  const curves = (status: GuidanceMessage['status']) => {
    const snapshot = { connection: 'open', capabilities: { isLive: true }, isPlaying: true, guidance: { status } };
    const player = {
      getSnapshot: () => snapshot,
      subscribe: () => () => undefined,
      clock: () => ({ timeS: 0, startS: 0, endS: 0 }),
      read: () => ({ timeS: new Float64Array(0), values: [], isComplete: true }),
    };
    const layout = { angles: ['humerus_forearm_left_zxy_flexion'], segments: [], points: [], scalars: [] };
    const props = { session: { layout }, player, columns: null, exercise: null } as unknown as LiveProps;
    return renderPage(<JointCurves {...props} id="a" title="Angles" templateAt={() => null} />, { answers: {} });
  };
  const moving = curves('moving');
  expect(screen.getByText(/^Template/)).toBeTruthy();
  moving.unmount();
  curves('paused');
  expect(screen.queryByText(/^Template/)).toBeNull();
  expect(screen.getByText(/No repetition is followed/)).toBeTruthy();
});

const jobs = (...kinds: string[]) =>
  kinds.map((kind) => ({ id: kind, kind, status: 'queued', progress: 0, message: '', session_id: 's' }));
const closing = { id: 's', state: 'closing', purpose: 'exercise', pipeline: 'arm' };

it.each([
  ['balance', null, false],
  ['arm', null, false],
  ['arm', 'p', true],
])('speaks of a template only where there is one: %s, prescription %s', async (pipeline, prescription_id, isSaid) => {
  const session = { ...closing, pipeline, prescription_id } as unknown as SessionDetail;
  renderPage(<AnalysisWait session={session} state="closing" />, {
    answers: { '/api/sessions/s': session, '/api/sessions/s/jobs': jobs('reprocess', 'compare') },
  });
  await screen.findByText('Estimating the movement');
  expect(screen.queryByText('Comparing with the template') !== null).toBe(isSaid);
});

it('calls a session by one name, in the list and on its page', async () => {
  expect(sessionTitle({ exercise_name: null, pipeline: 'relative_pose' })).toBe('Distance by magnetic source');
  renderPage(<SessionPanel patient={{ id: 'p' } as Patient} />, {
    answers: {
      '/api/patients/p/sessions': [
        {
          id: 's',
          state: 'analysed',
          exercise_name: null,
          pipeline: 'relative_pose',
          created_at: '2026-01-02T10:00:00Z',
        },
      ],
    },
  });
  expect(await screen.findByText('Distance by magnetic source')).toBeTruthy();
});

it('says of a session without calibration that it has none, with no sign that all is well', () => {
  const unknown = sensor('sternum', { heading_trusted: false, is_starting: true });
  const { container } = renderPage(
    <>
      <SensorLine health={health(unknown)} isUncalibrated />
      <HealthPanel health={health(unknown)} placements={['sternum']} isUncalibrated />
    </>,
    { answers: {} },
  );
  expect(screen.getAllByText('Not calibrated yet')).toHaveLength(2);
  expect(screen.queryByText(/Starting/)).toBeNull();
  expect(container.querySelector('.tabler-icon-check')).toBeNull();
});
