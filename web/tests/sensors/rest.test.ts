// A session that a second window ends: the window that measures sends all of it first, or the end is put off.
import 'fake-indexeddb/auto';
import { IDBFactory } from 'fake-indexeddb';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { sendRest, setMeasuring } from '../../src/sensors/registry';
import type { Measuring } from '../../src/sensors/rest';
import { answerOthers, sendRestElsewhere } from '../../src/sensors/rest';
import { holdStoreKey } from '../../src/sensors/gateway/seal';
import { FakeService } from './fakeService';
import { KEY, leavePackets, leftOf, workWith } from './fakeWorker';

let end: (() => void) | null = null;

/** Another window that measures for a session. */
function measures(settled: Measuring['settled'], sessionId = 's') {
  end = answerOthers({ sessionId, settled, stop: () => undefined });
}

beforeEach(() => {
  vi.stubGlobal('indexedDB', new IDBFactory());
  holdStoreKey(KEY);
});
afterEach(() => {
  end?.();
  end = null;
  setMeasuring(null);
  vi.unstubAllGlobals();
});

describe('a second window that ends a session', () => {
  it('waits until the one that measures has sent all', async () => {
    const order: string[] = [];
    measures(async () => {
      await new Promise((resolve) => setTimeout(resolve, 150));
      order.push('sent');
      return true;
    });
    expect(await sendRest('s')).toBe(true);
    order.push('ended');
    expect(order).toEqual(['sent', 'ended']);
  });

  it('does not end it while some is left', async () => {
    measures(() => Promise.resolve(false));
    expect(await sendRest('s')).toBe(false);
  });

  it('leaves a window alone that measures for another session', async () => {
    const settled = vi.fn(() => Promise.resolve(true));
    measures(settled, 'other');
    expect(await sendRest('s')).toBe(true);
    expect(settled).not.toHaveBeenCalled();
  });

  it('does not cut a window off that has something and does not answer', async () => {
    await leavePackets(2);
    vi.stubGlobal('navigator', {
      locks: { query: () => Promise.resolve({ held: [{ name: 'telemotion.measuring' }] }) },
    });
    expect(await sendRest('s')).toBe(false);
  });

  it('sends what a window that is gone has left, before the end', async () => {
    await leavePackets(4);
    const service = new FakeService();
    workWith(service);
    vi.stubGlobal('fetch', () => Promise.resolve(Response.json({ ticket: 'one' })));
    let isOver = false;
    const end = sendRest('s').then((isSafe) => {
      isOver = true;
      return isSafe;
    });
    await vi.waitFor(() => expect(service.stored.size).toBe(4), 4000);
    // Sent is not stored: the end waits for the acknowledgement.
    expect(isOver).toBe(false);
    service.acknowledge();
    expect(await end).toBe(true);
    expect([...service.stored.keys()]).toEqual([0, 1, 2, 3]);
    expect(service.duplicates).toBe(0);
    expect(await leftOf()).toBe(0);
  });

  it('puts the end off while what is left cannot be sent', async () => {
    await leavePackets(4);
    const service = new FakeService();
    service.isReachable = false;
    workWith(service);
    expect(await sendRestElsewhere('s', 600)).toBe(false);
    expect(service.stored.size).toBe(0);
    expect(await leftOf()).toBe(4);
  });

  it('ends on a page without cryptography, where nothing can have been stored', async () => {
    vi.stubGlobal('crypto', { getRandomValues: crypto.getRandomValues.bind(crypto) });
    expect(await sendRestElsewhere('s', 600)).toBe(true);
  });

  it('needs no key where nothing is left', async () => {
    holdStoreKey('?');
    expect(await sendRestElsewhere('s', 600)).toBe(true);
  });

  it('asks nobody where it measures itself', async () => {
    setMeasuring({ sessionId: 's', settled: () => Promise.resolve(false), stop: () => undefined });
    expect(await sendRest('s')).toBe(false);
  });
});
