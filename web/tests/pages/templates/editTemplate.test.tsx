import { fireEvent, screen, waitFor, within } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import axe from 'axe-core';
import { afterEach, expect, it, vi } from 'vitest';
import type { PhaseCurve, TemplateDesign, TemplateVersionDetail } from '../../../src/api/types';
import { EditTemplatePage } from '../../../src/pages/template/editor/EditTemplate';
import { renderPage } from '../render';

afterEach(() => vi.unstubAllGlobals());

const MAIN = 'humerus_forearm_right_zxy_flexion';
const LEAN = 'trunk_lean_forward_rad';
const curve = (channel: string, label: string, top: number): PhaseCurve => {
  const mean = Array.from({ length: 101 }, (_, at) => top * Math.sin((Math.PI * at) / 100));
  return {
    channel,
    label,
    unit: 'deg',
    mean,
    low: mean.map((value) => value - 10),
    high: mean.map((value) => value + 10),
    width: mean.map(() => 10),
    is_judged: true,
    repetitions: [mean],
  };
};
const version: TemplateVersionDetail = {
  id: 'v1',
  number: 1,
  created_at: '2026-11-20T10:00:00Z',
  repetition_count: 5,
  source_session_id: 's',
  reason: '',
  made_by: 'Ingrid Solberg',
  template_id: 't',
  exercise_id: 'e',
  patient_id: null,
  name: 'Reach',
  side: 'right',
  primary_channel: MAIN,
  reach_m: 0.55,
  design: {
    stops: [{ kind: 'lost', hold_s: 2 }],
    cues: [
      { quantity: 'deviation', sentence: 'guidance.sit_tall', channel: LEAN, side: 'above', tolerance: 0.14 },
      { quantity: 'slow', sentence: 'guidance.quicker', tolerance: 1.5 },
    ],
  },
  content: {
    duration_s: 3,
    repetitions: [{ number: 1, start_s: 0, end_s: 3, is_kept: true, reason: '', sentences: {} }],
    curves: [curve(MAIN, 'Elbow flexion', 60), curve(LEAN, 'Trunk forward lean', 8)],
    movement_onset_phases: [],
    measures: [
      { measure: `range:${MAIN}`, label: 'Elbow flexion, range of motion', unit: 'deg', value: 60 },
      { measure: 'duration', label: 'Duration', unit: 's', value: 3 },
    ],
  },
};
const open = (shown = version) =>
  renderPage(<EditTemplatePage />, {
    at: '/templates/versions/v1',
    path: '/templates/versions/:versionId',
    answers: {
      '/api/template-versions/v1': shown,
      'POST /api/templates/t/versions': [201, { ...version, id: 'v2', number: 2 }],
    },
  });

async function saved(view: ReturnType<typeof open>): Promise<TemplateDesign> {
  await userEvent.type(screen.getByRole('textbox', { name: 'Why this version?' }), 'less lean');
  await userEvent.click(screen.getByRole('button', { name: 'Save as version 2' }));
  await waitFor(() => expect(view.asked.some((one) => one.method === 'POST')).toBe(true));
  const body = view.asked.find((one) => one.method === 'POST')?.body as { design: TemplateDesign; based_on: string };
  expect(body).toMatchObject({ based_on: 'v1', reason: 'less lean' });
  return body.design;
}

it('draws a band on one phase with keys alone', async () => {
  const view = open();
  await userEvent.click(await screen.findByRole('button', { name: 'Suggest phases' }));
  expect(screen.getByRole<HTMLInputElement>('textbox', { name: 'Name of phase 2' }).value).toBe('Hold');
  const border = screen.getByRole('slider', { name: 'End of “Way out”, start of “Hold”' });
  expect(border.getAttribute('aria-valuenow')).toBe('36');
  border.focus();
  await userEvent.keyboard('{ArrowLeft}{ArrowLeft}{Shift>}{ArrowLeft}{/Shift}');
  expect(border.getAttribute('aria-valuenow')).toBe('29');

  await userEvent.click(screen.getByRole('button', { name: /^Trunk forward lean/ }));
  const upper = screen.getByRole('slider', { name: 'Way out: upper limit' });
  upper.focus();
  await userEvent.keyboard('{ArrowDown}{ArrowDown}{ArrowDown}');
  expect(upper.getAttribute('aria-valuetext')).toMatch(/7° above the curve/);
  const lower = screen.getByRole('slider', { name: 'Way back: lower limit' });
  lower.focus();
  await userEvent.keyboard('f');
  expect(lower.getAttribute('aria-valuetext')).toBe('no limit');
  await userEvent.keyboard('f');
  expect(lower.getAttribute('aria-valuetext')).toMatch(/10° below/);

  const design = await saved(view);
  expect(design.phases?.map((one) => [one.name, one.start, one.end])).toEqual([
    ['Way out', 0, 0.29],
    ['Hold', 0.29, 0.64],
    ['Way back', 0.64, 1],
  ]);
  expect(design.tolerances).toHaveLength(1);
  expect(design.tolerances?.[0]?.channel).toBe(LEAN);
  expect(design.tolerances?.[0]?.knots.map((one) => one.above)).toEqual([0.7, 0.7, 1, 1, 1, 1]);
});

it('weighs what the therapist weighs, and nothing else', async () => {
  const view = open();
  const add = await screen.findByRole('button', { name: 'Add a measure' });
  await userEvent.click(add);
  expect(screen.getByText('template: 60°')).toBeTruthy();
  await userEvent.click(add);
  // Each measure once: there are no more than these.
  expect(screen.queryByRole('button', { name: 'Add a measure' })).toBeNull();
  expect(screen.getByText('When it takes more than 1.5 times as long')).toBeTruthy();
  const weight = screen.getByRole('textbox', { name: 'Weight, for each s' });
  await userEvent.clear(weight);
  await userEvent.type(weight, '-2.5');
  const other = screen.getByRole('textbox', { name: 'Weight, for each degree' });
  await userEvent.clear(other);
  await userEvent.type(other, '0');
  expect(screen.getByText('A weight of zero has no effect and is not saved.')).toBeTruthy();
  const { violations } = await axe.run(document.body, {
    rules: { 'color-contrast': { enabled: false }, region: { enabled: false } },
  });
  expect(violations.map((one) => one.id)).toEqual([]);
  expect((await saved(view)).weights).toEqual([{ measure: 'duration', weight: -2.5 }]);
});

/** jsdom has no pointer events with places. */
const point = (element: Element, what: 'down' | 'move' | 'up', clientY: number) =>
  fireEvent(element, new MouseEvent(`pointer${what}`, { clientX: 10, clientY, bubbles: true, cancelable: true }));

it('draws with a pointer, and past the rim is free', async () => {
  const view = open();
  const grip = await screen.findByRole('slider', { name: 'Whole movement: upper limit' });
  const before = grip.getAttribute('transform');
  point(grip, 'down', 100);
  point(grip, 'move', 60);
  point(grip, 'up', 0);
  expect(grip.getAttribute('transform')).not.toBe(before);
  point(grip, 'move', 300);
  expect(Number(/ (.*)\)/.exec(grip.getAttribute('transform') ?? '')?.[1])).toBeCloseTo(60, 0);
  point(grip, 'down', 60);
  point(grip, 'move', -50);
  point(grip, 'up', 0);
  expect((await saved(view)).tolerances?.[0]?.knots[0]).toEqual({ phase: 0, below: 1, above: null });
});

it('says what counts, what stops and what is said', async () => {
  const view = open();
  await userEvent.click(await screen.findByRole('switch', { name: 'Trunk forward lean counts' }));
  expect(screen.getByText('Only watched: shown, never called wrong')).toBeTruthy();
  const stops = within(screen.getByRole('region', { name: 'What stops the exercise' }));
  await userEvent.click(stops.getByRole('button', { name: 'Add a limit' }));
  await userEvent.click(stops.getByRole('switch', { name: 'Stop after this many minutes' }));
  const cues = within(screen.getByRole('region', { name: 'What is said' }));
  expect(cues.getByText('When trunk forward lean is more than 8° too large')).toBeTruthy();
  await userEvent.type(cues.getByRole('textbox', { name: /Words to say when trunk/ }), 'Back to the chair');
  await userEvent.click(cues.getByRole('switch', { name: 'On: A bit quicker.' }));
  await userEvent.click(cues.getByRole('button', { name: 'Add a cue' }));
  await userEvent.type(cues.getByRole('textbox', { name: 'Say' }), 'Straighten the elbow');
  await userEvent.click(cues.getByRole('button', { name: 'Add a cue' }));

  const design = await saved(view);
  expect(design.watched).toEqual([LEAN]);
  expect(design.stops).toEqual([
    // The recording reaches 60 degrees: its extreme and ten more.
    {
      kind: 'limit',
      channel: MAIN,
      limit: expect.closeTo((70 * Math.PI) / 180) as number,
      side: 'above',
      hold_s: 0.05,
    },
    { kind: 'lost', hold_s: 2 },
    { kind: 'time', limit: 300, hold_s: 0 },
  ]);
  expect(design.cues?.map((one) => [one.words, one.is_on, one.channel])).toEqual([
    ['Back to the chair', undefined, LEAN],
    [undefined, false, undefined],
    ['Straighten the elbow', true, MAIN],
  ]);
});

it('says before saving that the recording itself breaks a limit, with the value, on both sides', async () => {
  open();
  const stops = within(await screen.findByRole('region', { name: 'What stops the exercise' }));
  await userEvent.click(stops.getByRole('button', { name: 'Add a limit' }));
  await userEvent.type(screen.getByRole('textbox', { name: 'Why this version?' }), 'limit');
  const save = screen.getByRole<HTMLButtonElement>('button', { name: 'Save as version 2' });
  expect(save.disabled).toBe(false);
  expect(screen.getByText('Limit 70°'), 'drawn in the curve').toBeTruthy();
  const value = stops.getByRole('textbox', { name: 'Limit in degrees' });
  await userEvent.clear(value);
  await userEvent.type(value, '50');
  expect(
    stops.getByText('Your own recording reaches 60°: the exercise would stop each time. 63° or more.'),
  ).toBeTruthy();
  expect(save.disabled).toBe(true);
  // The other side has a proposal of its own, in its direction.
  await userEvent.click(stops.getByRole('radio', { name: 'below' }));
  expect(save.disabled).toBe(false);
  expect(stops.getByRole<HTMLInputElement>('textbox', { name: 'Limit in degrees' }).value).toBe('-10°');
});

it('can be read and used by everybody', async () => {
  const view = open();
  await userEvent.click(await screen.findByRole('button', { name: 'Suggest phases' }));
  await userEvent.click(screen.getByRole('button', { name: 'Add a limit' }));
  const rules = { 'color-contrast': { enabled: false }, region: { enabled: false } };
  const found = await axe.run(view.container, { rules });
  expect(found.violations.map((one) => `${one.id}: ${one.nodes[0]?.html}`)).toEqual([]);
  expect(screen.getByRole('button', { name: 'Save as version 2' }).getAttribute('disabled')).not.toBe(null);
});

it('puts the value of a grip at the rim beside it, and names no reach of a leg', async () => {
  const channel = 'thigh_shank_right_zxy_flexion';
  const bent = curve(channel, 'Knee flexion', -60);
  const [low, high] = [-4, 4].map((by) => bent.mean.map((value) => (value ?? 0) + by));
  const knee = { ...bent, low: low ?? [], high: high ?? [], width: bent.mean.map(() => 4) };
  open({ ...version, primary_channel: channel, content: { ...version.content, curves: [knee] } });
  const valueOf = (name: string) => screen.getByRole('slider', { name }).querySelector('.band-value');
  await screen.findByRole('slider', { name: 'Whole movement: lower limit' });
  expect(valueOf('Whole movement: lower limit')?.getAttribute('text-anchor')).toBe('start');
  expect(valueOf('Whole movement: upper limit')?.getAttribute('text-anchor')).toBe('middle');
  expect(screen.queryByText(/with a reach of/)).toBeNull();
});

it('shows of a walk its phases and bands, and nothing that is followed live', async () => {
  const height = 'foot_height_right_m';
  const walk: TemplateVersionDetail = {
    ...version,
    primary_channel: height,
    is_guided: false,
    design: {
      phases: [
        { name: 'Stance', start: 0, end: 0.6 },
        { name: 'Swing', start: 0.6, end: 1 },
      ],
      watched: ['foot_speed_right_mps'],
      stops: [],
      cues: [],
    },
    content: {
      ...version.content,
      curves: [
        { ...curve(height, 'Foot height', 0.2), unit: 'm' },
        { ...curve('foot_speed_right_mps', 'Forward speed of the foot', 4), unit: 'm/s' },
      ],
    },
  };
  open(walk);
  await screen.findByText('Main curve, always counts');
  expect(screen.getByLabelText<HTMLInputElement>('Name of phase 2').value).toBe('Swing');
  expect(screen.queryByRole('heading', { name: 'What stops the exercise' })).toBeNull();
  expect(screen.queryByText(/55 cm/), 'no reach').toBeNull();
  await userEvent.click(screen.getByRole('button', { name: /^Forward speed of the foot/ }));
  const limit = screen.getByLabelText<HTMLInputElement>('Swing: how far above, in metres a second');
  expect(limit.disabled, 'what is only watched has no limit to set').toBe(true);
});
