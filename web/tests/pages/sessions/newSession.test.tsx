import { act, screen, within } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { afterEach, describe, expect, it, vi } from 'vitest';
import { NewSessionPage } from '../../../src/pages/session/NewSession';
import { renderPage } from '../render';

afterEach(() => vi.unstubAllGlobals());
Element.prototype.scrollIntoView = () => undefined;

const open = () =>
  renderPage(<NewSessionPage />, {
    at: '/patients/p/session',
    path: '/patients/:patientId/session',
    answers: {
      '/api/patients/p': {
        id: 'p',
        given_name: 'Tomasz',
        family_name: 'Lindqvist',
        affected_side: 'left',
        has_mounting: false,
        mounting: null,
      },
      '/api/exercises': [],
      '/api/patients/p/prescriptions': [],
      '/api/estimators': [],
      'POST /api/sessions': { id: 's' },
    },
  });
const kind = async (name: RegExp) =>
  within(await screen.findByRole('group', { name: /What is recorded/ })).getByLabelText(name);
const go = () => userEvent.click(screen.getByRole('button', { name: /Continue/ }));

describe('a new session', () => {
  it('leaves the keyboard on the kind that it chooses', async () => {
    open();
    for (const name of [/^Walking/, /^Balance test/, /^Arms, trunk and legs/]) {
      const radio = await kind(name);
      await userEvent.click(radio);
      expect(document.activeElement).toBe(radio);
      expect(radio).toHaveProperty('checked', true);
    }
  });

  it.each([
    [/^Arms, trunk and legs/, 'arm', ['sternum', 'upper_arm_left', 'forearm_left', 'hand_left']],
    [/^Walking/, 'gait', ['foot_left', 'foot_right']],
    [/^Balance test/, 'balance', ['pelvis', 'sternum']],
  ])('of %s declares its pipeline and what is worn', async (name, pipeline, placements) => {
    const { asked } = open();
    await userEvent.click(await kind(name));
    await go();
    const sent = asked.find((one) => one.path === '/api/sessions');
    expect(sent?.body).toMatchObject({ patient_id: 'p', pipeline, placements, purpose: 'exercise' });
  });

  it('asks for the filter and for iron under Advanced only, which is closed', async () => {
    const { container } = open();
    await kind(/^Arms, trunk and legs/);
    const fold = screen.getByText('Advanced').closest('details');
    expect(fold?.open).toBe(false);
    const outside = container.cloneNode(true) as HTMLElement;
    outside.querySelectorAll('details').forEach((one) => one.remove());
    expect(outside.textContent).not.toMatch(/orientation is estimated|Near iron/);
    expect(fold?.textContent).toMatch(/Near iron/);
  });

  it('asks before sensors that were chosen are left, and not once the session is made', async () => {
    sessionStorage.clear();
    const { router } = open();
    await userEvent.click(await screen.findByRole('checkbox', { name: 'Pelvis' }));
    await act(() => router.navigate('/elsewhere'));
    await userEvent.click(await screen.findByRole('button', { name: 'Stay here' }));
    await go();
    expect(await screen.findByText('elsewhere')).toBeTruthy();
    expect(router.state.location.pathname).toBe('/sessions/s/live');
    expect(sessionStorage).toHaveLength(0);
  });
});
