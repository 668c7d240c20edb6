// A session that a second window ends: the window that measures sends all of it first, or the end is put off.
import 'fake-indexeddb/auto';
import { IDBFactory } from 'fake-indexeddb';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { PacketStore, type StoredNetwork } from '../../src/sensors/gateway/store';
import { sendRest, setMeasuring, type Measuring } from '../../src/sensors/registry';
import { answerOthers } from '../../src/sensors/rest';

const network: StoredNetwork = {
  sessionId: 's',
  accountId: 'a',
  placements: ['upper_arm_right'],
  rateHz: 60,
  device: 'phone',
  next: 0,
};

let end: (() => void) | null = null;

/** Another window that measures for a session. */
function measures(settled: Measuring['settled'], sessionId = 's') {
  end = answerOthers({ sessionId, settled, stop: () => undefined });
}

async function leave(packets: number) {
  const store = await PacketStore.open();
  await store.declare(network);
  for (let sequence = 0; sequence < packets; sequence += 1) await store.put('s', sequence, new Uint8Array([sequence]));
  store.close();
}

beforeEach(() => {
  vi.stubGlobal('indexedDB', new IDBFactory());
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
    await leave(2);
    vi.stubGlobal('navigator', {
      locks: { query: () => Promise.resolve({ held: [{ name: 'telemotion.measuring' }] }) },
    });
    expect(await sendRest('s')).toBe(false);
  });

  it('asks nobody where it measures itself', async () => {
    setMeasuring({ sessionId: 's', settled: () => Promise.resolve(false), stop: () => undefined });
    expect(await sendRest('s')).toBe(false);
  });
});
