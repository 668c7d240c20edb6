import { fireEvent, screen, waitFor } from '@testing-library/react';
import { afterEach, expect, it, vi } from 'vitest';
import { OwnAccountPage } from '../../../src/pages/OwnAccount';
import type { Me } from '../../../src/api/types';
import { renderPage, THERAPIST } from '../render';

const SECRET = 'GEZDGNBVGY3TQOJQGEZDGNBVGY3TQOJQ';

afterEach(() => vi.unstubAllGlobals());

it('sets two-step sign-in up with a picture to scan and shows the recovery codes once', async () => {
  const { asked } = renderPage(<OwnAccountPage />, {
    answers: {
      '/api/me/second-factor': { is_on: false, since: null, recovery_codes_left: 0 },
      'POST /api/me/second-factor': { secret: SECRET, uri: `otpauth://totp/Telemotion:i@example.org?secret=${SECRET}` },
      'POST /api/me/second-factor/confirm': { codes: ['aaaa-bbbb-cccc-dddd'] },
    },
  });
  const begin = await screen.findByRole('button', { name: 'Set up' });
  // The card above asks for it as well, to change it.
  fireEvent.change(screen.getAllByLabelText('Current password').at(-1)!, { target: { value: 'my own' } });
  fireEvent.click(begin);
  expect(await screen.findByRole('img', { name: /QR code/ })).toBeTruthy();
  expect(asked.find((one) => one.path === '/api/me/second-factor' && one.method === 'POST')?.body).toEqual({
    password: 'my own',
  });
  expect(screen.getByText(/GEZD GNBV/)).toBeTruthy();
  fireEvent.change(screen.getByLabelText('Code from the app'), { target: { value: '123456' } });
  fireEvent.click(screen.getByRole('button', { name: 'Turn on' }));
  await waitFor(() => expect(screen.getByText('aaaa-bbbb-cccc-dddd')).toBeTruthy());
});

it.each([
  ['a patient whose password is her own now', null, 1],
  ['somebody who must still set up a second step', 'second_factor', 0],
] as const)('leads %s on after the password was changed', async (_, must, ways) => {
  const me: Me = { ...THERAPIST, role: 'patient', patient_id: 'p', must };
  renderPage(<OwnAccountPage />, {
    me,
    answers: {
      'POST /api/me/password': {},
      '/api/me/second-factor': { is_on: false, since: null, recovery_codes_left: 0 },
    },
  });
  expect(screen.queryByRole('link', { name: 'Go on' })).toBeNull();
  fireEvent.change(screen.getByLabelText('Current password'), { target: { value: 'a first password' } });
  fireEvent.change(screen.getByLabelText('New password'), { target: { value: 'her own password' } });
  fireEvent.click(screen.getByRole('button', { name: 'Change password' }));
  await screen.findByText(/^Password changed/);
  await waitFor(() => expect(screen.queryAllByRole('link', { name: 'Go on' })).toHaveLength(ways));
  for (const link of screen.queryAllByRole('link', { name: 'Go on' })) expect(link.getAttribute('href')).toBe('/');
});
