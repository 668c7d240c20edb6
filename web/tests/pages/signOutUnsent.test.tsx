// Signing out on a device that holds movement which is not sent: said first, and only to whom it belongs.
import 'fake-indexeddb/auto';
import { screen } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { IDBFactory } from 'fake-indexeddb';
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { wantedSignOut } from '../../src/api/signOut';
import { useSignOut } from '../../src/components/account/useSignOut';
import { speakLanguage } from '../../src/i18n/languages';
import { leavePackets, leftOf, NETWORK } from '../sensors/fakeWorker';
import { renderPage } from './render';

function Page() {
  const [signOut, question] = useSignOut('a', true);
  return (
    <>
      <button onClick={signOut}>leave</button>
      {question}
    </>
  );
}

const leave = async () => {
  renderPage(<Page />, { answers: {} });
  await userEvent.click(screen.getByRole('button', { name: 'leave' }));
};

beforeEach(() => {
  localStorage.clear();
  vi.stubGlobal('indexedDB', new IDBFactory());
});
afterEach(async () => {
  localStorage.clear();
  vi.unstubAllGlobals();
  await speakLanguage('en');
});

it('signs out at once where everything is sent', async () => {
  await leave();
  await vi.waitFor(() => expect(wantedSignOut()).toBe('asked'));
  expect(screen.queryByRole('dialog')).toBeNull();
});

it('says how much is not sent, and what becomes of it; it stays for the next sign-in', async () => {
  await leavePackets(40);
  await leave();
  const asked = await screen.findByRole('dialog');
  expect(asked.textContent).toContain('4 seconds of movement');
  expect(asked.textContent).toContain('after four weeks');
  expect(wantedSignOut()).toBeNull();
  await userEvent.click(screen.getByRole('button', { name: 'Sign out' }));
  expect(wantedSignOut()).toBe('asked');
  expect(await leftOf()).toBe(40);
});

it('stays signed in where somebody changes her mind', async () => {
  await leavePackets(40);
  await leave();
  await screen.findByRole('dialog');
  await userEvent.click(screen.getByRole('button', { name: 'Cancel' }));
  expect(wantedSignOut()).toBeNull();
});

it('says nothing of what another person measured', async () => {
  await leavePackets(40, { ...NETWORK, accountId: 'somebody-else' });
  await leave();
  await vi.waitFor(() => expect(wantedSignOut()).toBe('asked'));
  expect(screen.queryByRole('dialog')).toBeNull();
});

it('says it in German', async () => {
  await speakLanguage('de');
  await leavePackets(10);
  await leave();
  expect((await screen.findByRole('dialog')).textContent).toContain('Nur auf diesem Gerät gespeichert: eine Sekunde');
});
