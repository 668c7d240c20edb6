// What waits on a device: nobody reads it without the account's key, it has an end, and nothing of it is lost.
import 'fake-indexeddb/auto';
import { IDBFactory } from 'fake-indexeddb';
import { beforeEach, expect, it, vi } from 'vitest';
import { FORGOTTEN_AFTER_DAYS, PacketStore } from '../../src/sensors/gateway/store';
import { forgetOld, unsentSeconds } from '../../src/sensors/unsentHere';
import { KEY, leavePackets, leftOf, NETWORK } from './fakeWorker';

const ANOTHER = 'B'.repeat(43) + '=';
const MOVEMENT = new TextEncoder().encode('the angle of an elbow, 59 degrees');

beforeEach(() => void vi.stubGlobal('indexedDB', new IDBFactory()));

function opened(): Promise<IDBDatabase> {
  return new Promise((resolve, reject) => {
    const request = indexedDB.open('telemotion-sensors');
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(new Error('not opened'));
  });
}

async function rowsOf(name: string): Promise<{ sealed: ArrayBuffer }[]> {
  const database = await opened();
  const request = database.transaction(name).objectStore(name).getAll();
  await new Promise((resolve) => (request.onsuccess = resolve));
  database.close();
  return request.result as { sealed: ArrayBuffer }[];
}

/** All that the browser's database holds, as somebody with the device reads it. */
async function inClear(): Promise<string> {
  const text = (value: unknown): string => {
    if (value instanceof ArrayBuffer || ArrayBuffer.isView(value)) return new TextDecoder('latin1').decode(value);
    if (typeof value === 'object' && value !== null) return Object.entries(value).flat().map(text).join(' ');
    return String(value);
  };
  return text([await rowsOf('packets'), await rowsOf('sessions')]);
}

async function left(key: string) {
  const store = await PacketStore.open(key);
  await store.declare({ ...NETWORK, device: 'Pixel of Ada' });
  await store.put(NETWORK.sessionId, 0, MOVEMENT);
  return store;
}

it('holds neither movement nor device in clear, and gives both to the account that measured them', async () => {
  (await left(KEY)).close();
  const seen = await inClear();
  expect(seen).toContain(NETWORK.sessionId);
  for (const secret of ['elbow', 'Pixel', 'upper_arm']) expect(seen).not.toContain(secret);
  // Signed in again, in a page that was opened anew.
  const store = await PacketStore.open(KEY);
  expect((await store.network(NETWORK.sessionId))?.device).toBe('Pixel of Ada');
  const [packet] = await store.read(NETWORK.sessionId, 0, 10);
  expect(new TextDecoder().decode(packet?.bytes)).toContain('59 degrees');
});

it('opens with no other key, and writes nothing without one', async () => {
  (await left(KEY)).close();
  const other = await PacketStore.open(ANOTHER);
  await expect(other.network(NETWORK.sessionId)).rejects.toThrow();
  expect(await other.read(NETWORK.sessionId, 0, 10)).toEqual([]);
  const nobody = await PacketStore.open('');
  await expect(nobody.put(NETWORK.sessionId, 1, MOVEMENT)).rejects.toThrow('nobody is signed in');
  await expect(nobody.network(NETWORK.sessionId)).rejects.toThrow('nobody is signed in');
  expect(await leftOf()).toBe(1);
});

it('takes no packet for another one', async () => {
  const store = await left(KEY);
  const database = await opened();
  const moved = database.transaction('packets', 'readwrite');
  const rows = moved.objectStore('packets');
  rows.get([NETWORK.sessionId, 0]).onsuccess = ({ target }) =>
    rows.put({ ...(target as IDBRequest<object>).result, sequence: 1 });
  await new Promise((resolve) => (moved.oncomplete = resolve));
  database.close();
  expect((await store.read(NETWORK.sessionId, 0, 10)).map((one) => one.sequence)).toEqual([0]);
});

it('seals each packet differently', async () => {
  const store = await left(KEY);
  await store.put(NETWORK.sessionId, 1, MOVEMENT);
  const [first, second] = await rowsOf('packets');
  expect(new Uint8Array(first!.sealed)).not.toEqual(new Uint8Array(second!.sealed));
});

it('sends what a version before left in clear, and deletes it as the rest', async () => {
  await new Promise<void>((resolve) => {
    const request = indexedDB.open('telemotion-sensors', 1);
    request.onupgradeneeded = () => {
      const packets = request.result.createObjectStore('packets', { keyPath: ['sessionId', 'sequence'] });
      packets.put({ sessionId: 's', sequence: 0, bytes: MOVEMENT });
      request.result.createObjectStore('sessions', { keyPath: 'sessionId' }).put(NETWORK);
    };
    request.onsuccess = () => {
      request.result.close();
      resolve();
    };
  });
  const store = await PacketStore.open(KEY);
  expect(await store.sessions('a')).toEqual(['s']);
  expect(await store.network('s')).toEqual(NETWORK);
  expect((await store.read('s', 0, 10))[0]?.bytes).toEqual(MOVEMENT);
  await store.removeOld(Date.now() + 1000);
  expect(await leftOf()).toBe(1);
  await store.removeOld(Date.now() + (FORGOTTEN_AFTER_DAYS + 1) * 86_400_000);
  expect(await leftOf()).toBe(0);
});

it('counts for the account alone what is not sent, and has an end for everybody’s', async () => {
  await leavePackets(40);
  expect(await unsentSeconds('a')).toBeCloseTo(4);
  expect(await unsentSeconds('b')).toBe(0);
  await forgetOld();
  expect(await leftOf()).toBe(40);
  vi.useFakeTimers({ toFake: ['Date'], now: Date.now() + (FORGOTTEN_AFTER_DAYS + 1) * 86_400_000 });
  await forgetOld();
  vi.useRealTimers();
  expect(await leftOf()).toBe(0);
  expect(await unsentSeconds('a')).toBe(0);
});

it('reads on past what another key sealed, and lets nobody wait for it', async () => {
  await leavePackets(120, NETWORK, ANOTHER);
  const store = await PacketStore.open(KEY);
  await store.put(NETWORK.sessionId, 120, MOVEMENT);
  expect(await store.count(NETWORK.sessionId)).toBe(121);
  expect((await store.read(NETWORK.sessionId, 0, 50)).map((one) => one.sequence)).toEqual([120]);
  expect(await store.read(NETWORK.sessionId, 0, 50, 99)).toEqual([]);
  expect(await store.count(NETWORK.sessionId)).toBe(1);
  await store.forget(NETWORK.sessionId, 59);
  expect(await store.count(NETWORK.sessionId)).toBe(1);
  await store.forget(NETWORK.sessionId, 120);
  expect(await store.count(NETWORK.sessionId)).toBe(0);
});
