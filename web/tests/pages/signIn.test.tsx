import { fireEvent, screen, waitFor } from '@testing-library/react';
import { afterEach, expect, it, vi } from 'vitest';
import { OwnAccountPage } from '../../src/pages/OwnAccount';
import { renderPage } from './render';

const SECRET = 'GEZDGNBVGY3TQOJQGEZDGNBVGY3TQOJQ';

afterEach(() => vi.unstubAllGlobals());

it('sets two-step sign-in up with a picture to scan and shows the recovery codes once', async () => {
  renderPage(<OwnAccountPage />, {
    answers: {
      '/api/me/second-factor': { is_on: false, since: null, recovery_codes_left: 0 },
      'POST /api/me/second-factor': { secret: SECRET, uri: `otpauth://totp/Telemotion:i@example.org?secret=${SECRET}` },
      'POST /api/me/second-factor/confirm': { codes: ['aaaa-bbbb-cccc-dddd'] },
    },
  });
  fireEvent.click(await screen.findByRole('button', { name: 'Set up' }));
  expect(await screen.findByRole('img', { name: /QR code/ })).toBeTruthy();
  expect(screen.getByText(/GEZD GNBV/)).toBeTruthy();
  fireEvent.change(screen.getByLabelText('Code from the app'), { target: { value: '123456' } });
  fireEvent.click(screen.getByRole('button', { name: 'Turn on' }));
  await waitFor(() => expect(screen.getByText('aaaa-bbbb-cccc-dddd')).toBeTruthy());
});
