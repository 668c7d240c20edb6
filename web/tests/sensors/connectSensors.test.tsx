import { cleanup, screen } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { afterEach, expect, it, vi } from 'vitest';
import type { SessionDetail } from '../../src/api/types';
import ConnectSensors from '../../src/sensors/ConnectSensors';
import { renderPage } from '../pages/render';

afterEach(() => vi.unstubAllGlobals());

const session = (placements: string[]) => ({ id: 's', patient_id: 'p', placements }) as SessionDetail;
const ARM = ['sternum', 'upper_arm_right', 'forearm_right', 'hand_right'];

it('shows the steps with the box, and the other ways below', () => {
  renderPage(<ConnectSensors session={session(ARM)} isWaiting box={<p>the steps</p>} />, { answers: {} });
  expect(screen.getByText('the steps')).toBeTruthy();
  expect(screen.getAllByRole('button').map((one) => one.textContent)).toEqual([
    expect.stringContaining('This phone'),
    expect.stringContaining('Bluetooth sensors'),
    expect.stringContaining('A new box'),
  ]);
});

it('offers no phone where no upper arm is worn, and nothing once something measures', () => {
  const { rerender } = renderPage(<ConnectSensors session={session(['foot_left'])} isWaiting />, { answers: {} });
  expect(screen.queryByRole('button', { name: /This phone/ })).toBeNull();
  rerender(<ConnectSensors session={session(['foot_left'])} isWaiting={false} />);
  expect(screen.queryByRole('button')).toBeNull();
});

it('offers in mid-exercise only what goes on with this session on this device', () => {
  const buttonsOf = (placements: string[]) => {
    cleanup();
    renderPage(<ConnectSensors session={session(placements)} isWaiting isMidway />, { answers: {} });
    return screen.queryAllByRole('button').map((one) => one.textContent);
  };
  expect(buttonsOf(ARM)).toEqual([expect.stringContaining('Bluetooth sensors')]);
  expect(screen.getByRole('heading', { name: 'Did this device measure?' })).toBeTruthy();
  // A phone with a session of its own goes on; a desktop is none.
  expect(buttonsOf(['upper_arm_right'])).toHaveLength(1);
  vi.stubGlobal('navigator', { ...navigator, maxTouchPoints: 5 });
  expect(buttonsOf(['upper_arm_right'])).toEqual([
    expect.stringContaining('This phone'),
    expect.stringContaining('Bluetooth sensors'),
  ]);
});

it('says what one phone sees and does not see, and why it cannot measure here', async () => {
  renderPage(<ConnectSensors session={session(ARM)} isWaiting />, { answers: {} });
  await userEvent.click(screen.getByRole('button', { name: /This phone/ }));
  expect(screen.getByText(/how far you lift your arm/)).toBeTruthy();
  expect(screen.getByText(/does not see your elbow/)).toBeTruthy();
  // jsdom is neither secure nor a phone.
  vi.stubGlobal('isSecureContext', false);
  await userEvent.click(screen.getByRole('button', { name: 'Measure with this phone' }));
  expect((await screen.findByRole('alert')).textContent).toContain('https');
});

it('gives a new box its code, to scan and to type', async () => {
  const { asked } = renderPage(<ConnectSensors session={session(ARM)} isWaiting />, {
    answers: {
      'POST /api/patients/p/pairing-codes': [201, { code: 'ABCD2345', expires_at: '2026-11-22T12:00:00Z' }],
    },
  });
  await userEvent.click(screen.getByRole('button', { name: /A new box/ }));
  await userEvent.click(await screen.findByRole('button', { name: 'Show the code' }));
  expect(await screen.findByText('ABCD 2345')).toBeTruthy();
  expect(screen.getByRole('img', { name: /QR code/ })).toBeTruthy();
  expect(asked.at(-1)?.body).toEqual({ label: 'Box at home', days: 90 });
});
