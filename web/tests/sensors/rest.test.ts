// A session that a second window ends: the window that measures sends all of it first, or the end is put off.
import 'fake-indexeddb/auto';
import { IDBFactory } from 'fake-indexeddb';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { FromWorker, ToWorker } from '../../src/sensors/gateway/messages';
import { encodePacket, MOTION } from '../../src/sensors/gateway/packet';
import { Recorder } from '../../src/sensors/gateway/recorder';
import { PacketStore, type StoredNetwork } from '../../src/sensors/gateway/store';
import { sendRest, setMeasuring, type Measuring } from '../../src/sensors/registry';
import { answerOthers, sendRestElsewhere } from '../../src/sensors/rest';
import { FakeService } from './fakeService';

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

/** The worker of the page's gateway, in the page: jsdom has none. What it sends goes to this service. */
function workWith(service: FakeService) {
  vi.stubGlobal(
    'Worker',
    class {
      onmessage: ((event: { data: FromWorker }) => void) | null = null;
      #recorder: Recorder | null = null;
      postMessage(message: ToWorker) {
        if (message.type === 'begin') void this.#begin(message);
        else if (message.type === 'close') void this.#recorder?.close();
      }
      async #begin({ network, url }: Extract<ToWorker, { type: 'begin' }>) {
        const onState = () => {
          if (this.#recorder) this.onmessage?.({ data: { type: 'state', state: this.#recorder.state } });
        };
        const { ticket, create } = service;
        const store = await PacketStore.open();
        this.#recorder = new Recorder({ network, url, store, ticket, create, random: () => 0, onState });
        await this.#recorder.begin();
      }
    },
  );
}

/** A window that is gone has left packets of half a second each. */
async function leavePackets(count: number) {
  const store = await PacketStore.open();
  await store.declare(network);
  for (let sequence = 0; sequence < count; sequence += 1) {
    const values = new Float32Array(30 * 6).fill(sequence);
    const deviceTimeUs = BigInt(500_000 * sequence);
    const fields = { sequence, deviceTimeUs, tickIntervalUs: 16_667, sensors: 1, ticks: 30, channels: MOTION, values };
    await store.put('s', sequence, encodePacket(fields));
  }
  store.close();
}

async function leftOf(): Promise<number> {
  const store = await PacketStore.open();
  const left = await store.count('s');
  store.close();
  return left;
}

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

  it('sends what a window that is gone has left, before the end', async () => {
    await leavePackets(4);
    const service = new FakeService();
    workWith(service);
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

  it('asks nobody where it measures itself', async () => {
    setMeasuring({ sessionId: 's', settled: () => Promise.resolve(false), stop: () => undefined });
    expect(await sendRest('s')).toBe(false);
  });
});
