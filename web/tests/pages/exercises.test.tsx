// An exercise is done standing or sitting: asked when it is added, changed later, and shown in its line.
import { screen, waitFor } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { describe, expect, it } from 'vitest';
import { ExercisePage } from '../../src/pages/ExercisePage';
import { ExercisesPage } from '../../src/pages/Exercises';
import { renderPage } from './render';

const EXERCISE = {
  id: 'e',
  name: 'Drink',
  description: 'Reach for the cup.',
  movement: 'drinking',
  side: 'right',
  primary_angle: 'humerus_forearm_right_zxy_flexion',
  posture: 'standing',
};

describe('how an exercise is done', () => {
  it('is what is usual of its movement until somebody chooses', async () => {
    const { asked } = renderPage(<ExercisesPage />, {
      answers: { '/api/exercises': [EXERCISE], '/api/templates': [], 'POST /api/exercises': [201, EXERCISE] },
    });
    expect(await screen.findByText('Drinking · Right arm · Standing')).toBeTruthy();
    await userEvent.click(screen.getByRole('button', { name: 'Add exercise' }));
    await userEvent.type(await screen.findByRole('textbox', { name: 'Name' }), 'Reach');
    const seated = () => screen.getByRole<HTMLInputElement>('radio', { name: 'Sitting' });
    expect(seated().checked).toBe(true);
    await userEvent.click(screen.getByRole('radio', { name: 'Standing' }));
    expect(seated().checked).toBe(false);
    await userEvent.click(screen.getByRole('button', { name: 'Save' }));
    await waitFor(() =>
      expect(asked.find(({ method }) => method === 'POST')?.body).toMatchObject({ name: 'Reach', posture: 'standing' }),
    );
  });

  it('names the limb whose angle counts', async () => {
    const knee = { ...EXERCISE, name: 'Straighten', movement: 'other', primary_angle: 'thigh_shank_left_zxy_flexion' };
    renderPage(<ExercisesPage />, {
      answers: { '/api/exercises': [{ ...knee, side: 'left', posture: 'seated' }], '/api/templates': [] },
    });
    expect(await screen.findByText('Another movement · Left leg · Sitting')).toBeTruthy();
  });

  it('is not repeated where the name says it', async () => {
    const walk = { ...EXERCISE, id: 'w', name: 'Timed up and go', movement: 'timed_up_and_go', description: '' };
    renderPage(<ExercisesPage />, { answers: { '/api/exercises': [walk], '/api/templates': [] } });
    const card = (await screen.findByRole('heading', { name: 'Timed up and go' })).closest('li');
    expect(card?.textContent?.match(/Timed up and go/g)).toHaveLength(1);
  });

  it('can be changed later, and nothing of what is measured', async () => {
    const { asked } = renderPage(<ExercisePage />, {
      at: '/exercises/e',
      path: '/exercises/:exerciseId',
      answers: {
        '/api/exercises': [EXERCISE],
        '/api/templates?exercise_id=e': [],
        'PATCH /api/exercises/e': { ...EXERCISE, posture: 'seated' },
      },
    });
    await userEvent.click(await screen.findByRole('button', { name: 'Change exercise' }));
    await userEvent.click(await screen.findByRole('radio', { name: 'Sitting' }));
    await userEvent.click(screen.getByRole('button', { name: 'Save' }));
    await waitFor(() =>
      expect(asked.find(({ method }) => method === 'PATCH')?.body).toEqual({
        name: 'Drink',
        description: 'Reach for the cup.',
        posture: 'seated',
      }),
    );
  });
});
