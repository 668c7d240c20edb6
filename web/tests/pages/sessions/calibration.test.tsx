import { useState } from 'react';
import { screen } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { afterEach, describe, expect, it, vi } from 'vitest';
import type { CalibrationGuide, CalibrationMessage } from '../../../src/api/types';
import { wornLimbs } from '../../../src/lib/calibration';
import { CalibrationPanel, panelOf, type CalibrationPanelProps } from '../../../src/pages/calibration/CalibrationPanel';
import { onDisc } from '../../../src/pictures/CoverageSphere';
import { renderPage } from '../render';

afterEach(() => vi.unstubAllGlobals());

const guide = (kind: CalibrationGuide['kind'], change: Partial<CalibrationGuide> = {}): CalibrationGuide => ({
  kind,
  title: kind,
  summary: `About ${kind}.`,
  worn: true,
  one_sensor: false,
  steps: [{ key: 'pose', title: 'Hold it', instruction: 'Stand still.', picture: 'n_pose', ends: 'itself' }],
  ...change,
});
const GUIDES = [
  guide('n_pose'),
  guide('functional', { title: 'By movement' }),
  guide('magnetometer', { title: 'Compass', worn: false, one_sensor: true }),
  guide('heading_reset'),
];
const message = (change: Partial<CalibrationMessage>): CalibrationMessage => ({
  type: 'calibration',
  kind: 'n_pose',
  phase: 'collecting',
  steps: GUIDES[0]?.steps ?? [],
  step: 0,
  step_progress: 0.4,
  hint: 'Keep still.',
  score: null,
  result: null,
  ...change,
});

/** The panel as the live page holds it: it goes when its result was read and nothing else is wanted. */
function Panel(props: Omit<CalibrationPanelProps, 'shows' | 'onRead'>) {
  const [read, setRead] = useState<CalibrationMessage | null>(null);
  const shows = panelOf(props.guide, read, props.isNeeded);
  return shows && <CalibrationPanel {...props} shows={shows} onRead={setRead} />;
}

const show = (now: CalibrationMessage | null, isNeeded = true) =>
  renderPage(
    <Panel
      sessionId="s"
      placements={['upper_arm_right', 'forearm_right']}
      guide={now}
      hint=""
      mayAct
      isNeeded={isNeeded}
      onClose={() => undefined}
    />,
    {
      answers: {
        '/api/calibrations': GUIDES,
        'POST /api/sessions/s/calibration/start': message({}),
        'POST /api/sessions/s/calibration/next': message({}),
      },
    },
  );

describe('guided calibration', () => {
  it('starts with the usual pose, one button', async () => {
    const { asked } = show(null);
    await userEvent.click(await screen.findByRole('button', { name: 'Calibrate' }));
    expect(asked.at(-1)).toMatchObject({ path: '/api/sessions/s/calibration/start', body: { kind: 'n_pose' } });
  });
  it('asks for the directions first where the mounting is remembered', async () => {
    const { asked } = renderPage(
      <Panel
        sessionId="s"
        placements={['upper_arm_right']}
        guide={null}
        hint=""
        mayAct
        isNeeded
        isRemembered
        onClose={() => undefined}
      />,
      {
        answers: { '/api/calibrations': GUIDES, 'POST /api/sessions/s/calibration/start': message({}) },
      },
    );
    await userEvent.click(await screen.findByRole('button', { name: 'Set the directions' }));
    expect(asked.at(-1)?.body).toEqual({ kind: 'heading_reset' });
    expect(screen.getByRole('button', { name: 'Calibrate again from the start' })).toBeTruthy();
  });
  it('says how to stand while the directions are set for the first time, and that they are set', () => {
    const steps = [
      {
        key: 'pose',
        title: 'Let the arms hang',
        instruction: 'Facing as at the calibration.',
        picture: 'arm_hanging' as const,
        ends: 'itself' as const,
      },
    ];
    const panel = (now: CalibrationMessage, isRemembered: boolean) =>
      renderPage(
        <Panel
          sessionId="s"
          placements={['upper_arm_right']}
          guide={now}
          hint=""
          mayAct
          isNeeded
          isRemembered={isRemembered}
          onClose={() => undefined}
        />,
        { answers: { '/api/calibrations': GUIDES } },
      );
    const running = message({ kind: 'heading_reset', steps });
    const first = panel(running, true);
    expect(screen.getByText(/look straight ahead/)).toBeTruthy();
    expect(screen.queryByText(/as at the calibration/)).toBeNull();
    first.unmount();
    const later = panel(running, false);
    expect(screen.getByText(/as at the calibration/)).toBeTruthy();
    later.unmount();
    panel({ ...running, phase: 'done', score: 1 }, false);
    expect(screen.getByRole('heading', { name: 'The directions are set' })).toBeTruthy();
  });
  it('tells the field that each sensor saw, and which cannot be the earth’s', () => {
    const fields = [
      {
        placement: 'sternum' as const,
        norm_ut: 48.4,
        dip_deg: 66,
        norm_before_ut: 47.1,
        dip_before_deg: 65.4,
        is_plausible: true,
      },
      {
        placement: 'forearm_right' as const,
        norm_ut: 91,
        dip_deg: null,
        norm_before_ut: null,
        dip_before_deg: null,
        is_plausible: false,
      },
    ];
    show(
      message({
        kind: 'magnetometer',
        phase: 'done',
        score: 0.9,
        fields,
        axes: [{ name: 'elbow_flexion_right', range_deg: 101, sigma_deg: 0.04 }],
        reasons: ['forearm right sensor: the field here is 91 microtesla.'],
      }),
    );
    expect(screen.getByText('48 µT, dip 66°')).toBeTruthy();
    expect(screen.getByText('± 0.04°')).toBeTruthy();
    expect(screen.getByText(/last time 47 µT, dip 65°/)).toBeTruthy();
    expect(screen.getByText('91 µT').textContent).toContain('not plausible');
    expect(screen.getByText(/Expected: 25 to 65 µT/)).toBeTruthy();
    expect(screen.getByText(/the field here is 91 microtesla/)).toBeTruthy();
  });
  it('offers other ways, and a sensor in the hand by its place', async () => {
    const { asked } = show(null);
    await userEvent.click(await screen.findByText(/themselves, in the hand/));
    await userEvent.click(screen.getAllByRole('button', { name: 'Begin' }).at(-1) as HTMLElement);
    expect(asked.at(-1)?.body).toEqual({ kind: 'magnetometer', placements: ['upper_arm_right'] });
    // The heading has a button of its own in the live view.
    expect(screen.queryByText('About heading_reset.')).toBeNull();
  });
  it('says what to do now and what to mend', () => {
    show(message({}));
    expect(screen.getByRole('heading', { name: 'Hold it' })).toBeTruthy();
    expect(screen.getByRole('status').textContent).toBe('Keep still.');
    expect(screen.getByRole('progressbar').getAttribute('aria-valuenow')).toBe('40');
  });
  it('lets a person end a movement, but not before it can hold three repetitions', async () => {
    const steps = [
      { key: 'rest', title: 'Stand still', instruction: '', picture: 'n_pose' as const, ends: 'itself' as const },
      {
        key: 'elbow_flexion',
        title: 'Bend the elbow',
        instruction: 'Three times.',
        picture: 'elbow_flexion' as const,
        ends: 'next' as const,
      },
    ];
    const early = show(message({ kind: 'functional', steps, step: 1, step_progress: 0.5 }));
    expect(screen.getByRole('button', { name: 'Done, evaluate' })).toHaveProperty('disabled', true);
    early.unmount();
    const { asked } = show(message({ kind: 'functional', steps, step: 1, step_progress: 1 }));
    await userEvent.click(screen.getByRole('button', { name: 'Done, evaluate' }));
    expect(asked.at(-1)?.path).toBe('/api/sessions/s/calibration/next');
  });
  it('names a swapped sensor on the body and what to do again', () => {
    show(
      message({
        phase: 'redo',
        reasons: ['Swap them and begin again.'],
        redo_steps: ['pose'],
        findings: [
          {
            code: 'swapped_segments',
            placements: ['upper_arm_right', 'forearm_right'],
            text: 'Upper arm and forearm are swapped.',
          },
        ],
      }),
    );
    expect(screen.getByRole('img').getAttribute('aria-label')).toMatch(/right upper arm, right forearm/);
    expect(screen.getByText('Upper arm and forearm are swapped.')).toBeTruthy();
    expect(screen.getByText('Repeat these steps: Hold it.')).toBeTruthy();
  });
  it('shows nothing when nothing is asked for', () => {
    show(null, false);
    expect(screen.queryByRole('button')).toBeNull();
  });
});

it('knows the limbs that carry sensors', () => {
  expect(wornLimbs(['sternum', 'upper_arm_left', 'hand_right'])).toEqual(['right_arm', 'left_arm', 'trunk']);
});

it('draws equal areas of the ball as equal areas of the disc', () => {
  expect(onDisc([0, 0, 1])).toEqual([0, -0]);
  expect(Math.hypot(...onDisc([1, 0, 0]))).toBeCloseTo(1);
  // Half of the upper half's area lies within 60 degrees of the pole.
  expect(Math.hypot(...onDisc([Math.sin(Math.PI / 3), 0, 0.5])) ** 2).toBeCloseTo(0.5);
});
