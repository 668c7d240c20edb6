// What a window that is gone left on the device: said, sent once, and forgotten, on the patient's first page.
import 'fake-indexeddb/auto';
import { screen, waitFor } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { IDBFactory } from 'fake-indexeddb';
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { sentencesReady, speakLanguage } from '../../src/i18n/languages';
import { holdStoreKey } from '../../src/sensors/gateway/seal';
import { PacketStore } from '../../src/sensors/gateway/store';
import Unsent from '../../src/sensors/Unsent';
import { type Answers, renderPage } from '../pages/render';
import { FakeService } from './fakeService';
import { KEY, leavePackets, leftOf, NETWORK, workWith } from './fakeWorker';

const HEADING = 'Not sent yet';
const SENT = /has been sent to your clinic/;
const superseded = {
  type: 'error',
  code: 'conflict',
  message: 'A newer connection has taken over this session.',
  sentences: { message: { code: 'live.superseded', params: {} } },
  details: { reason: 'superseded' },
  closing: true,
};

let service: FakeService;

beforeEach(() => {
  vi.stubGlobal('indexedDB', new IDBFactory());
  service = new FakeService();
  workWith(service);
  holdStoreKey(KEY);
});
afterEach(async () => {
  Reflect.deleteProperty(navigator, 'locks');
  vi.unstubAllGlobals();
  await speakLanguage('en');
});

const TICKET = { 'POST /api/sessions/s/ticket': { ticket: 'one' } };
const stateIs = (code: string) => ({ 'POST /api/sessions/s/reopen': { sentences: { reason: { code, params: {} } } } });

const open = (answers: Answers = { ...TICKET, ...stateIs('live.connection_ended') }) =>
  renderPage(<Unsent />, { answers });

/** Long enough for the page to have looked into the database of the browser. */
const looked = () => new Promise((resolve) => setTimeout(resolve, 100));

/** The browser's locks as other windows have them, by name. */
function othersHold(...held: string[]) {
  const waiting: { name: string; work: () => unknown }[] = [];
  const locks = {
    request: (name: string, options: { signal?: AbortSignal }, work: () => unknown) => {
      if (!held.includes(name)) return Promise.resolve(work());
      waiting.push({ name, work: () => !options.signal?.aborted && work() });
      return new Promise(() => undefined);
    },
    query: () => Promise.resolve({ held: held.map((name) => ({ name })) }),
  };
  Object.defineProperty(navigator, 'locks', { value: locks, configurable: true });
  return {
    letGo: (name: string) => {
      held.splice(held.indexOf(name), 1);
      for (const one of waiting) if (one.name === name) one.work();
    },
    take: (name: string) => held.push(name),
  };
}

it('shows nothing where nothing was left, and forgets what a session was', async () => {
  await leavePackets(0);
  open();
  await vi.waitFor(async () => {
    const store = await PacketStore.open('');
    const left = await store.sessions(NETWORK.accountId);
    store.close();
    expect(left).toEqual([]);
  });
  expect(screen.queryByRole('heading')).toBeNull();
  expect(service.sockets).toHaveLength(0);
});

it('says what is left, sends it when there is a link, once, and says that it is sent', async () => {
  service.isReachable = false;
  await leavePackets(40);
  open();
  expect(await screen.findByRole('heading', { name: HEADING })).toBeTruthy();
  const left = '4 seconds of movement from an earlier exercise.';
  expect(
    await screen.findByText(`Still on this device: ${left} It is sent as soon as there is a connection.`),
  ).toBeTruthy();
  expect(service.stored.size).toBe(0);

  service.isReachable = true;
  await vi.waitFor(() => expect(service.stored.size).toBe(40));
  // What is sent is not stored before it is acknowledged: it stays on the device, and the page says so.
  expect(await screen.findByText(`Being sent to your clinic: ${left}`)).toBeTruthy();
  expect(await leftOf()).toBe(40);
  service.acknowledge();
  expect(await screen.findByText(SENT)).toBeTruthy();
  await waitFor(() => expect(screen.queryByRole('heading', { name: HEADING })).toBeNull());
  expect([...service.stored.keys()]).toEqual(Array.from({ length: 40 }, (_, sequence) => sequence));
  expect([...service.stored.values()].every((one) => one.isBackfilled)).toBe(true);
  expect(service.duplicates).toBe(0);
  expect(await leftOf()).toBe(0);
});

it('sends nothing that another person measured on this device, and does not say that it is there', async () => {
  await leavePackets(4, { ...NETWORK, accountId: 'somebody-else' });
  open();
  await looked();
  expect(service.sockets).toHaveLength(0);
  expect(screen.queryByRole('heading')).toBeNull();
  expect(await leftOf()).toBe(4);
});

it('leaves a window alone that measures', async () => {
  othersHold('telemotion.measuring');
  await leavePackets(4);
  open();
  await looked();
  expect(service.sockets).toHaveLength(0);
  expect(screen.queryByRole('heading')).toBeNull();
});

it('waits while another window sends the same, and goes on when that one is closed', async () => {
  const sending = `telemotion.sending.${NETWORK.sessionId}`;
  const others = othersHold(sending);
  await leavePackets(4);
  open();
  await looked();
  expect(service.sockets).toHaveLength(0);
  others.letGo(sending);
  await vi.waitFor(() => expect(service.stored.size).toBe(4));
});

it('leaves what is left to a window that begins to measure for the same session', async () => {
  const others = othersHold();
  service.isReachable = false;
  await leavePackets(4);
  open();
  expect(await screen.findByRole('heading', { name: HEADING })).toBeTruthy();
  others.take('telemotion.measuring');
  service.refusal = superseded;
  service.isReachable = true;
  await waitFor(() => expect(screen.queryByRole('heading', { name: HEADING })).toBeNull());
  expect(screen.queryByText(SENT)).toBeNull();
  expect(await leftOf()).toBe(4);
});

it('says in the reader’s words why nothing can be sent now', async () => {
  await speakLanguage('de');
  await sentencesReady();
  service.refusal = superseded;
  await leavePackets(10);
  open();
  expect((await screen.findByRole('alert')).textContent).toBe('Für diese Übung misst jetzt ein anderes Gerät.');
  expect(screen.getByText(/noch etwas gespeichert: eine Sekunde\. Es lässt sich gerade nicht senden/)).toBeTruthy();
  expect(await leftOf()).toBe(10);
});

it('puts another refusal of the service into the reader’s language', async () => {
  await speakLanguage('de');
  await sentencesReady();
  service.refusal = {
    type: 'error',
    code: 'not_allowed',
    message: 'A newer connection has taken over this session.',
    sentences: { message: { code: 'live.superseded', params: {} } },
    closing: true,
  };
  await leavePackets(10);
  open();
  const words = (await screen.findByRole('alert')).textContent;
  expect(words).toContain('Verbindung');
  expect(words).not.toContain('connection');
});

it('sends for a session that has ended since, and ends it again', async () => {
  await leavePackets(10);
  const { asked } = open({ ...TICKET, ...stateIs('live.reopened'), 'POST /api/sessions/s/close': {} });
  await vi.waitFor(() => expect(service.stored.size).toBe(10));
  const paths = () => asked.map(({ path }) => path.split('/').at(-1));
  expect(paths()).toEqual(['reopen', 'ticket']);
  service.acknowledge();
  expect(await screen.findByText(SENT)).toBeTruthy();
  await vi.waitFor(() => expect(paths()).toEqual(['reopen', 'ticket', 'close']));
});

it('leaves a session open that was open', async () => {
  await leavePackets(10);
  const { asked } = open();
  await vi.waitFor(() => expect(service.stored.size).toBe(10));
  service.acknowledge();
  expect(await screen.findByText(SENT)).toBeTruthy();
  await looked();
  expect(asked.map(({ path }) => path.split('/').at(-1))).toEqual(['reopen', 'ticket']);
});

it('says that what is left is not taken any more, and deletes it when asked', async () => {
  const refused = { code: 'not_found', message: 'There is no such session.', details: {} };
  await leavePackets(10);
  open({ 'POST /api/sessions/s/reopen': [404, refused] });
  expect(
    await screen.findByText(/one second of movement from an earlier exercise\. Your clinic does not/),
  ).toBeTruthy();
  expect(service.stored.size).toBe(0);
  expect(await leftOf()).toBe(10);
  await userEvent.click(screen.getByRole('button', { name: 'Delete from this device' }));
  const sure = await screen.findByRole('dialog');
  await userEvent.click([...sure.querySelectorAll('button')].at(-1)!);
  await waitFor(() => expect(screen.queryByRole('heading', { name: HEADING })).toBeNull());
  expect(await leftOf()).toBe(0);
  // What was deleted was not sent.
  expect(screen.queryByText(SENT)).toBeNull();
});

it('says that what was sealed with a key of earlier cannot be sent, and deletes it when asked', async () => {
  await leavePackets(10, NETWORK, 'B'.repeat(43) + '=');
  open();
  expect(await screen.findByText(/locked with a key that the service no longer has/)).toBeTruthy();
  expect(service.sockets).toHaveLength(0);
  expect(await leftOf()).toBe(10);
  await userEvent.click(screen.getByRole('button', { name: 'Delete from this device' }));
  const sure = await screen.findByRole('dialog');
  await userEvent.click([...sure.querySelectorAll('button')].at(-1)!);
  await waitFor(() => expect(screen.queryByRole('heading', { name: HEADING })).toBeNull());
  expect(await leftOf()).toBe(0);
});
