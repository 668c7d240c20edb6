import { screen, within } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { afterEach, expect, it, vi } from 'vitest';
import type { Patient } from '../../../src/api/types';
import { NewSessionPage } from '../../../src/pages/session/NewSession';
import { renderPage } from '../render';

afterEach(() => vi.unstubAllGlobals());
// The list of a choice scrolls to what is chosen; this document has no layout.
Element.prototype.scrollIntoView = () => undefined;

const PATIENT = {
  id: 'p',
  given_name: 'Tomasz',
  family_name: 'Lindqvist',
  affected_side: 'left',
  has_mounting: false,
  mounting: null,
} as unknown as Patient;
const SAID = { patient_has_no_implant: true, people_nearby_have_none: true };

it('makes a session with a source only after both questions were answered by no', async () => {
  const { asked, router } = renderPage(<NewSessionPage />, {
    at: '/patients/p/session',
    path: '/patients/:patientId/session',
    answers: {
      '/api/patients/p': PATIENT,
      '/api/exercises': [],
      '/api/patients/p/prescriptions': [],
      '/api/estimators': [],
      '/api/magnetic-sources': [
        {
          id: 'm',
          name: 'Belt',
          serial: 'S-1',
          gain_sigma: 0.004,
          method: 'session',
          calibrated_at: '2026-11-01T10:00:00Z',
        },
      ],
      'POST /api/sessions': { id: 's' },
      'POST /api/sessions/s/magnetic-safety': {},
    },
  });
  const pick = async (question: RegExp, answer: RegExp) =>
    userEvent.click(within(await screen.findByRole('group', { name: question })).getByLabelText(answer));
  await pick(/What is recorded/, /Distance by magnetic source/);
  await pick(/Body part/, /^Leg/);
  await userEvent.click(
    await screen
      .findByRole('textbox', { name: 'Which source is worn' })
      .catch(() => screen.findByRole('combobox', { name: 'Which source is worn' })),
  );
  await userEvent.click(
    await screen.findByRole('option', { name: /Belt – Serial number S-1. Field uncertainty 0.4 %/, hidden: true }),
  );
  expect(screen.queryByText(/Coils of the source, where/)).toBeNull();
  const go = screen.getByRole('button', { name: /Continue/ });
  expect(go).toHaveProperty('disabled', true);
  await pick(/Ask the patient/, /^No$/);
  await pick(/everybody who will be near/, /not sure/);
  expect(go).toHaveProperty('disabled', true);
  expect(screen.getByRole('alert').textContent).toMatch(/Do not use the source/);
  await pick(/everybody who will be near/, /^No$/);
  await userEvent.click(go);
  const posts = asked.filter((one) => one.method === 'POST');
  expect(posts.map((one) => one.path)).toEqual(['/api/sessions', '/api/sessions/s/magnetic-safety']);
  expect(posts[0]?.body).toMatchObject({
    pipeline: 'relative_pose',
    placements: ['pelvis', 'thigh_left'],
    orientation_parameters: { source: 'pelvis' },
    magnetic_source_id: 'm',
  });
  expect(posts[1]?.body).toEqual(SAID);
  expect(router.state.location.pathname).toBe('/sessions/s/live');
});
