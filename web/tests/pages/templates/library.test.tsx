import { screen, waitFor, within } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import axe from 'axe-core';
import { afterEach, expect, it, vi } from 'vitest';
import type { Exercise, Template, TemplateVersionDetail } from '../../../src/api/types';
import { ExercisesPage } from '../../../src/pages/Exercises';
import { TemplateCard } from '../../../src/pages/template/TemplateCard';
import { renderPage } from '../render';

afterEach(() => vi.unstubAllGlobals());

const exercise: Exercise = {
  id: 'e',
  name: 'Reach',
  movement: 'reaching',
  side: 'right',
  primary_angle: 'a',
  description: '',
};
const version = {
  id: 'v2',
  number: 2,
  created_at: '2025-11-20T10:00:00Z',
  repetition_count: 5,
  source_session_id: 's',
  reason: 'less lean',
  made_by: 'Ingrid Solberg',
};
const template: Template = {
  id: 't',
  exercise_id: 'e',
  patient_id: null,
  name: 'To the shelf',
  tags: ['stroke'],
  retired_at: null,
  created_at: '2025-11-19T10:00:00Z',
  versions: [version, { ...version, id: 'v1', number: 1, reason: '', made_by: 'Jonas Weber' }],
};
const rules = { region: { enabled: false }, 'color-contrast': { enabled: false } };

it('finds templates by words and tags, and retired ones on request', async () => {
  const view = renderPage(<ExercisesPage />, {
    answers: {
      '/api/exercises': [exercise],
      '/api/templates': [template],
      '/api/templates?words=stroke': [template],
      '/api/templates?words=nothing': [],
      '/api/templates?words=nothing&is_retired=true': [{ ...template, retired_at: '2025-11-21T10:00:00Z' }],
    },
  });
  const library = within(screen.getByRole('region', { name: 'Templates' }));
  expect(await library.findByRole('link', { name: 'To the shelf' })).toBeTruthy();
  expect(library.getByText('Reach · Right arm · version 2 of 20 Nov 2025, Ingrid Solberg')).toBeTruthy();
  expect((await axe.run(view.container, { rules })).violations.map((one) => one.id)).toEqual([]);
  await userEvent.click(library.getByRole('button', { name: 'Find templates with the tag stroke' }));
  await waitFor(() => expect(view.asked.some((one) => one.path.endsWith('words=stroke'))).toBe(true));
  const search = library.getByRole('searchbox', { name: 'Find a template' });
  await userEvent.clear(search);
  await userEvent.type(search, 'nothing');
  expect(await library.findByText('No template for “nothing”. Try fewer words.')).toBeTruthy();
  await userEvent.click(library.getByRole('switch', { name: 'Show retired ones' }));
  expect(await library.findByText('Retired')).toBeTruthy();
});

it('shows the history and retires, tags and mirrors a template', async () => {
  const detail = {
    ...version,
    template_id: 't',
    exercise_id: 'e',
    patient_id: null,
    name: 'To the shelf',
    side: 'right',
    primary_channel: 'a',
    reach_m: 0.55,
    design: {},
    content: { duration_s: 3, repetitions: [], curves: [], movement_onset_phases: [] },
    troubles: ['Stop rule 1: the recording reaches 88°.'],
  } satisfies TemplateVersionDetail;
  const view = renderPage(<TemplateCard template={template} wanted={null} primary="a" />, {
    answers: {
      '/api/template-versions/v2': detail,
      'PATCH /api/templates/t/entry': template,
      'POST /api/template-versions/v2/copies': [201, { ...detail, id: 'w', exercise_id: 'f' }],
    },
  });
  const sent = (method: string) => view.asked.find((one) => one.method === method)?.body;
  expect(await screen.findByText('Stop rule 1: the recording reaches 88°.')).toBeTruthy();
  await userEvent.click(await screen.findByRole('button', { name: 'Retire' }));
  await waitFor(() => expect(sent('PATCH')).toEqual({ is_retired: true }));
  await userEvent.click(screen.getByText('History: 2 versions'));
  expect(screen.getByText('less lean')).toBeTruthy();
  expect(screen.getByText(/Jonas Weber/)).toBeTruthy();
  expect(screen.getByText('Recorded: 5 repetitions')).toBeTruthy();
  await userEvent.click(screen.getByRole('button', { name: 'Mirror to the other side' }));
  const dialog = within(await screen.findByRole('dialog'));
  expect(dialog.getByRole<HTMLInputElement>('textbox', { name: 'Name' }).value).toBe('To the shelf, left');
  await userEvent.type(dialog.getByRole('textbox', { name: 'Why this version?' }), 'left arm first');
  await userEvent.click(dialog.getByRole('button', { name: 'Mirror to the other side' }));
  await waitFor(() => expect(view.router.state.location.pathname).toBe('/exercises/f'));
  expect(sent('POST')).toEqual({ patient_id: null, name: 'To the shelf, left', reason: 'left arm first' });
});
