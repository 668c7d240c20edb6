import { screen } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { afterEach, expect, it, vi } from 'vitest';
import type { Patient } from '../../../src/api/types';
import { DevicePanel } from '../../../src/pages/patient/DevicePanel';
import { renderPage } from '../render';

afterEach(() => vi.unstubAllGlobals());

it('shows a new gateway’s code to type and to scan', async () => {
  const { asked } = renderPage(<DevicePanel patient={{ id: 'p', may_manage: true, archived_at: null } as Patient} />, {
    answers: {
      '/api/patients/p/device-tokens': [],
      'POST /api/patients/p/pairing-codes': [201, { code: 'ABCD2345', expires_at: '2026-11-22T12:00:00Z' }],
    },
  });
  await userEvent.click(screen.getByRole('button', { name: 'Add' }));
  await userEvent.type(await screen.findByLabelText('Name'), 'Tablet at home');
  await userEvent.click(screen.getByRole('button', { name: 'Make pairing code' }));
  expect(await screen.findByText('ABCD 2345')).toBeTruthy();
  expect(screen.getByRole('img', { name: /QR code/ })).toBeTruthy();
  expect(asked.find((one) => one.path.endsWith('/pairing-codes'))?.body).toEqual({ label: 'Tablet at home', days: 90 });
  // The long token is not made, so that no second credential lies about.
  expect(asked.some((one) => one.method === 'POST' && one.path.endsWith('/device-tokens'))).toBe(false);
});
