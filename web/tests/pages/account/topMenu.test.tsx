import { screen, waitFor } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { afterEach, expect, it, vi } from 'vitest';
import { Shell } from '../../../src/components/Shell';
import { renderPage, THERAPIST } from '../render';

afterEach(() => vi.unstubAllGlobals());

it('opens a menu that comes late by keyboard, gives the focus back, and goes where it says', async () => {
  const { router } = renderPage(<Shell />, { answers: { '/api/me': THERAPIST } });
  const name = { name: 'Ingrid Solberg' };
  (await screen.findByRole('button', name)).focus();
  expect(screen.getByRole('button', name).getAttribute('aria-haspopup')).toBe('menu');
  await userEvent.keyboard('{Enter}');
  expect(await screen.findByRole('menuitem', { name: 'Sign out' })).toBeTruthy();
  expect(screen.getByText(/^Clinic · /)).toBeTruthy();
  await userEvent.keyboard('{Escape}');
  await waitFor(() => expect(screen.queryByRole('menuitem')).toBeNull());
  await waitFor(() => expect(document.activeElement).toBe(screen.getByRole('button', name)));
  // The second time it is there at once.
  await userEvent.keyboard('{Enter}');
  await userEvent.click(await screen.findByRole('menuitem', { name: 'My account' }));
  await waitFor(() => expect(router.state.location.pathname).toBe('/account'));
});
