// Two therapists at one template or prescription: the second one is not refused for ever, and loses nothing.
import { fireEvent, screen, waitFor, within } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import axe from 'axe-core';
import { afterEach, expect, it, vi } from 'vitest';
import type { Patient, Prescription, TemplateDesign, TemplateVersionDetail } from '../../../src/api/types';
import { EditTemplatePage } from '../../../src/pages/template/editor/EditTemplate';
import { MergePrescription } from '../../../src/pages/patient/prescribe/MergePrescription';
import { PrescribeForm } from '../../../src/pages/patient/prescribe/PrescribeForm';
import { valuesOf, type PrescribeValues } from '../../../src/pages/patient/prescribe/values';
import { renderPage, type Answers } from '../render';

afterEach(() => vi.unstubAllGlobals());

const MAIN = 'humerus_forearm_right_zxy_flexion';
const AT = '2026-11-20T23:30:00Z';
const mean = Array.from({ length: 101 }, (_, at) => 60 * Math.sin((Math.PI * at) / 100));
const opened: TemplateVersionDetail = {
  id: 'v1',
  number: 1,
  created_at: '2026-11-01T10:00:00Z',
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
  design: { stops: [], valid_share: 0.8 },
  content: {
    duration_s: 3,
    repetitions: [{ number: 1, start_s: 0, end_s: 3, is_kept: true, reason: '', sentences: {} }],
    curves: [
      {
        channel: MAIN,
        label: 'Elbow flexion',
        unit: 'deg',
        mean,
        low: mean.map((value) => value - 10),
        high: mean.map((value) => value + 10),
        width: mean.map(() => 10),
        is_judged: true,
        repetitions: [mean],
      },
    ],
    movement_onset_phases: [],
    measures: [],
  },
};
const newest: TemplateVersionDetail = {
  ...opened,
  id: 'v2',
  number: 2,
  created_at: AT,
  made_by: 'Tomas Lind',
  reason: 'two minutes are enough',
  design: {
    ...opened.design,
    // As the service stores a rule: with what a page leaves out.
    stops: [{ kind: 'time', channel: '', side: 'above', limit: 120, hold_s: 0 }],
    phases: [
      { name: 'Way out', start: 0, end: 0.5 },
      { name: 'Way back', start: 0.5, end: 1 },
    ],
  },
};
const refused = [
  409,
  {
    code: 'conflict',
    message: 'Tomas Lind saved version 2 after you opened this one.',
    details: { newest: 'v2', changed_by: 'Tomas Lind', changed_at: AT },
  },
];

it('joins a drawing with the version that somebody saved meanwhile, and saves on top of it', async () => {
  const answers: Answers = {
    '/api/template-versions/v1': opened,
    '/api/template-versions/v2': newest,
    'POST /api/templates/t/versions': refused,
  };
  const view = renderPage(<EditTemplatePage />, {
    at: '/templates/versions/v1',
    path: '/templates/versions/:versionId',
    answers,
  });
  await userEvent.click(await screen.findByRole('switch', { name: 'Stop after this many minutes' }));
  const minutes = await screen.findByRole('textbox', { name: 'Number for: Stop after this many minutes' });
  fireEvent.change(minutes, { target: { value: '4' } });
  fireEvent.change(screen.getByRole('textbox', { name: /valid from this share/ }), { target: { value: '70 %' } });
  await userEvent.type(screen.getByRole('textbox', { name: 'Why this version?' }), 'milder');
  await userEvent.click(screen.getByRole('button', { name: 'Save as version 2' }));

  const card = within(await screen.findByRole('alert', { name: 'Changed meanwhile' }));
  // By the clocks of this browser and in its language, never in UTC.
  const when = new Intl.DateTimeFormat('en-GB', { day: 'numeric', month: 'short' }).format(new Date(AT));
  const said = card.getByText(/^Tomas Lind saved version 2 after you opened this one/).textContent;
  expect(said).not.toContain('UTC');
  expect(said.includes(when) || /days ago|Today|Yesterday/i.test(said)).toBe(true);
  expect(card.getByText('Reason: “two minutes are enough”')).toBeTruthy();
  expect(card.getByText(/^Phases: Way out to 50 %, Way back to 100 %/)).toBeTruthy();
  const take = card.getByRole<HTMLButtonElement>('button', { name: 'Continue with both changes' });
  expect(take.disabled, 'both changed the time').toBe(true);
  const found = await axe.run(view.container, {
    rules: { 'color-contrast': { enabled: false }, region: { enabled: false } },
  });
  expect(found.violations.map((one) => `${one.id}: ${one.nodes[0]?.html}`)).toEqual([]);
  await userEvent.click(card.getByRole('radio', { name: /^4 min/ }));
  await userEvent.click(take);

  answers['POST /api/templates/t/versions'] = [201, { ...newest, id: 'v3', number: 3 }];
  expect(screen.getByText('The changes of both are here now. Check them, then save.')).toBeTruthy();
  await userEvent.click(screen.getByRole('button', { name: 'Save as version 3' }));
  await waitFor(() => expect(view.asked.filter((one) => one.method === 'POST')).toHaveLength(2));
  const body = view.asked.findLast((one) => one.method === 'POST')?.body as {
    based_on: string;
    reason: string;
    design: TemplateDesign;
  };
  expect(body.based_on).toBe('v2');
  expect(body.reason).toBe('milder');
  expect(body.design.stops).toEqual([{ kind: 'time', limit: 240, hold_s: 0 }]);
  expect(body.design.valid_share).toBe(0.7);
  expect(body.design.phases?.map((one) => one.name)).toEqual(['Way out', 'Way back']);
});

it('offers a drawing after somebody saved the next version, and joins both before anything is saved', async () => {
  const answers: Answers = {
    '/api/template-versions/v1': opened,
    '/api/template-versions/v2': newest,
    'POST /api/templates/t/versions': [201, { ...newest, id: 'v3', number: 3 }],
  };
  const at = (version: string) => ({
    at: `/templates/versions/${version}`,
    path: '/templates/versions/:versionId',
    answers,
  });
  sessionStorage.clear();
  const before = renderPage(<EditTemplatePage />, at('v1'));
  fireEvent.change(await screen.findByRole('textbox', { name: /valid from this share/ }), {
    target: { value: '70 %' },
  });
  await userEvent.type(screen.getByRole('textbox', { name: 'Why this version?' }), 'milder');
  before.unmount();

  const view = renderPage(<EditTemplatePage />, at('v2'));
  await userEvent.click(await screen.findByRole('button', { name: 'Continue with it' }));
  const card = within(await screen.findByRole('alert', { name: 'Changed meanwhile' }));
  expect(screen.getByRole<HTMLButtonElement>('button', { name: /^Save as version/ }).disabled).toBe(true);
  await userEvent.click(card.getByRole('button', { name: 'Continue with both changes' }));
  await userEvent.click(screen.getByRole('button', { name: 'Save as version 3' }));
  await waitFor(() => expect(view.asked.some((one) => one.method === 'POST')).toBe(true));
  const body = view.asked.find((one) => one.method === 'POST')?.body as { based_on: string; design: TemplateDesign };
  expect(body).toMatchObject({ based_on: 'v2', reason: 'milder' });
  expect(body.design.valid_share).toBe(0.7);
  expect(body.design.stops).toEqual([{ kind: 'time', limit: 120, hold_s: 0 }]);
  expect(body.design.phases?.map((one) => one.name)).toEqual(['Way out', 'Way back']);
});

const prescription = {
  id: 'x',
  exercise_id: 'e',
  template_id: null,
  repetitions: 10,
  sets: 1,
  times_per_week: 5,
  days: [],
  times: [],
  tolerance_scale: 1,
  stops: [],
  question: '',
  starts_at: '2026-11-01T10:00:00Z',
  ends_at: null,
  number: 1,
  changes: [],
} as unknown as Prescription;

it('joins a changed prescription with a change made meanwhile, even when the list was read anew behind the dialog', async () => {
  const done = vi.fn();
  const stored: Prescription = {
    ...prescription,
    repetitions: 20,
    sets: 2,
    number: 2,
    changes: [{ changed_by: 'Tomas Lind', changed_at: AT, before: { repetitions: 10, sets: 1 } }],
  };
  const answers: Answers = {
    '/api/exercises': [{ id: 'e', name: 'Raise the arm', movement: 'abduction', side: 'right', primary_angle: '' }],
    '/api/patients/p/prescriptions': [stored],
    '/api/templates?exercise_id=e&patient_id=p': [],
    'PATCH /api/prescriptions/x': [
      409,
      { code: 'conflict', message: 'changed', details: { changed_by: 'Tomas Lind', changed_at: AT } },
    ],
  };
  const view = renderPage(
    <PrescribeForm patient={{ id: 'p' } as Patient} prescription={prescription} onDone={done} />,
    { answers },
  );
  fireEvent.change(screen.getByRole('textbox', { name: 'Repetitions' }), { target: { value: '12' } });
  fireEvent.change(screen.getByRole('textbox', { name: /A question of yours/ }), { target: { value: 'Tired?' } });
  await userEvent.click(screen.getByRole('button', { name: 'Save the change' }));
  const card = within(await screen.findByRole('alert', { name: 'Changed meanwhile' }));
  expect(view.asked.filter((one) => one.path === '/api/patients/p/prescriptions').length).toBeGreaterThan(1);
  expect(card.getByText('Sets: 2 (before: 1)')).toBeTruthy();
  await userEvent.click(card.getByRole('radio', { name: /^20/ }));
  await userEvent.click(card.getByRole('button', { name: 'Continue with both changes' }));
  expect(screen.getByRole<HTMLInputElement>('textbox', { name: 'Sets' }).value).toBe('2');

  answers['PATCH /api/prescriptions/x'] = [200, stored];
  await userEvent.click(screen.getByRole('button', { name: 'Save the change' }));
  await waitFor(() => expect(done).toHaveBeenCalled());
  expect(
    view.asked.filter((one) => one.method === 'PATCH').map((one) => (one.body as { number: number }).number),
  ).toEqual([1, 2]);
  expect(view.asked.findLast((one) => one.method === 'PATCH')?.body).toMatchObject({
    number: 2,
    repetitions: 20,
    sets: 2,
    question: 'Tired?',
  });
});

it('keeps the new limit of each, names everybody who changed it, and says what I deleted', async () => {
  const limit = (value: number, hold_s: number, side: 'above' | 'below' = 'above') =>
    ({ kind: 'limit', channel: MAIN, side, limit: value, hold_s }) as const;
  const opened: Prescription = { ...prescription, stops: [limit(2, 0.05)] };
  const stored: Prescription = {
    ...opened,
    number: 3,
    stops: [limit(1.5, 0), limit(2, 0.05)],
    changes: [
      { changed_by: 'Tomas Lind', changed_at: AT, before: {} },
      { changed_by: 'Ingrid Solberg', changed_at: '2026-11-19T10:00:00Z', before: {} },
      { changed_by: 'Long Ago', changed_at: '2026-11-02T10:00:00Z', before: {} },
    ],
  };
  const onTake = vi.fn();
  renderPage(
    <MergePrescription
      base={opened}
      newest={stored}
      values={{ ...valuesOf(opened), stops: [limit(1, 2, 'below')] }}
      templates={[]}
      onTake={onTake}
    />,
    { answers: {} },
  );
  expect(screen.getByText(/^Ingrid Solberg and Tomas Lind changed this/)).toBeTruthy();
  expect(screen.getByText(/86°, at once \(before: none\)/)).toBeTruthy();
  expect(screen.getByText(/^You deleted: .*115°, beyond it for 0.05 s$/)).toBeTruthy();
  await userEvent.click(screen.getByRole('button', { name: 'Continue with both changes' }));
  expect((onTake.mock.calls[0]?.[0] as PrescribeValues).stops).toEqual([limit(1.5, 0), limit(1, 2, 'below')]);
});
