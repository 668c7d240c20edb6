import { act, fireEvent, screen, waitFor, within } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import axe from 'axe-core';
import { afterEach, expect, it, vi } from 'vitest';
import type { Exercise, Patient, Prescription, PrescriptionIn, Template } from '../../../src/api/types';
import { PrescribeForm } from '../../../src/pages/patient/prescribe/PrescribeForm';
import { renderPage } from '../render';

afterEach(() => vi.unstubAllGlobals());

const ANGLE = 'thorax_humerus_right_yxy_elevation';
const exercise: Exercise = {
  id: 'e',
  name: 'Raise the arm',
  movement: 'abduction',
  side: 'right',
  primary_angle: ANGLE,
  description: '',
};
const template: Template = {
  id: 't',
  exercise_id: 'e',
  patient_id: null,
  name: 'To the shelf',
  tags: [],
  retired_at: null,
  created_at: '',
  versions: [],
};

it('prescribes days, times, a wider band and a limit', async () => {
  const done = vi.fn();
  const view = renderPage(<PrescribeForm patient={{ id: 'p' } as Patient} onDone={done} />, {
    answers: {
      '/api/exercises': [exercise],
      '/api/patients/p/prescriptions': [],
      '/api/templates?exercise_id=e&patient_id=p': [template],
      'POST /api/patients/p/prescriptions': [201, {}],
    },
  });
  // A dialog puts the cursor there: the list of exercises must not cover it before it is asked for.
  const field = screen.getByRole('combobox', { name: 'Exercise' });
  act(() => field.focus());
  expect(field.getAttribute('aria-expanded')).toBe('false');
  await userEvent.click(field);
  await userEvent.click(await screen.findByRole('option', { name: 'Raise the arm', hidden: true }));
  expect(screen.getByRole('textbox', { name: 'Times per week' })).toBeTruthy();
  for (const day of ['Mon', 'Wed', 'Fri']) await userEvent.click(screen.getByRole('checkbox', { name: day }));
  expect(screen.queryByRole('textbox', { name: 'Times per week' })).toBeNull();
  expect(screen.getByText('3 sessions a week')).toBeTruthy();
  await userEvent.click(screen.getByRole('button', { name: 'Add a time' }));
  const band = await screen.findByRole('textbox', { name: 'Width of the band' });
  await userEvent.clear(band);
  await userEvent.type(band, '150');
  const limits = within(screen.getByRole('group', { name: 'Limits for this patient' }));
  await userEvent.click(limits.getByRole('button', { name: 'Add a limit' }));

  const rules = { region: { enabled: false }, 'color-contrast': { enabled: false } };
  const found = await axe.run(view.container, { rules });
  expect(found.violations.map((one) => one.id)).toEqual([]);

  await userEvent.click(screen.getByRole('button', { name: 'Prescribe' }));
  await waitFor(() => expect(done).toHaveBeenCalled());
  const body = view.asked.find((one) => one.method === 'POST')?.body as PrescriptionIn;
  expect(body).toMatchObject({
    template_id: 't',
    days: [1, 3, 5],
    times: ['09:00'],
    tolerance_scale: 1.5,
    stops: [{ kind: 'limit', channel: ANGLE, side: 'above' }],
  });
});

it('changes a dose with what is there filled in, and names the state that it changes', async () => {
  const done = vi.fn();
  const prescription = {
    id: 'x',
    exercise_id: 'e',
    template_id: 't',
    repetitions: 10,
    sets: 2,
    times_per_week: 5,
    days: [],
    times: [],
    tolerance_scale: 1,
    stops: [],
    question: '',
    ends_at: null,
    number: 3,
  } as unknown as Prescription;
  const view = renderPage(
    <PrescribeForm patient={{ id: 'p' } as Patient} prescription={prescription} onDone={done} />,
    {
      answers: {
        '/api/exercises': [exercise],
        '/api/patients/p/prescriptions': [prescription],
        '/api/templates?exercise_id=e&patient_id=p': [template],
        'PATCH /api/prescriptions/x': [200, {}],
      },
    },
  );
  const sets = screen.getByRole('textbox', { name: 'Sets' });
  fireEvent.change(sets, { target: { value: '3' } });
  await userEvent.click(screen.getByRole('button', { name: 'Save the change' }));
  await waitFor(() => expect(done).toHaveBeenCalled());
  const body = view.asked.find((one) => one.method === 'PATCH')?.body;
  expect(body).toMatchObject({ number: 3, sets: 3, repetitions: 10, template_id: 't' });
});
