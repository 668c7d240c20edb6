import 'fake-indexeddb/auto';
import { IDBFactory } from 'fake-indexeddb';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { Sample } from '../../src/sensors/gateway/grid';
import { Recorder } from '../../src/sensors/gateway/recorder';
import { PacketStore } from '../../src/sensors/gateway/store';
import { FakeService } from './fakeService';
import { KEY, NETWORK as network } from './fakeWorker';

const STEP_MS = 1000 / 60;
const sample = (n: number): Sample => [Math.fround(Math.sin(n)), n, 0, 0, 0, 9.75];

let factory: IDBFactory;
let service: FakeService;
let beat: ReturnType<typeof setInterval>;

beforeEach(() => {
  factory = new IDBFactory();
  service = new FakeService();
  beat = setInterval(() => service.acknowledge(), 20);
});
afterEach(() => clearInterval(beat));

async function recorderOf(): Promise<{ recorder: Recorder; store: PacketStore }> {
  const store = await PacketStore.open(KEY, factory);
  const recorder = new Recorder({
    url: '/ws/ingest',
    network,
    store,
    ticket: service.ticket,
    create: () => service.create(),
    random: () => 0,
    onState: () => undefined,
  });
  await recorder.begin();
  return { recorder, store };
}

/** Give samples, and wait until they are stored on the device. */
async function feed(recorder: Recorder, from: number, to: number): Promise<void> {
  for (let n = from; n < to; n += 1) recorder.add(0, (n + 1000) * STEP_MS, sample(n));
  await recorder.flush();
}

/** All samples that the service has, in order. */
function received(): number[] {
  return [...service.stored.values()]
    .sort((a, b) => a.sequence - b.sequence)
    .flatMap(({ bytes }) => {
      const view = new DataView(bytes.buffer, bytes.byteOffset);
      return Array.from({ length: bytes[5] ?? 0 }, (_, tick) => view.getFloat32(32 + tick * 24 + 4, true));
    });
}

const all = (count: number) => Array.from({ length: count }, (_, n) => n);
const near = (values: number[]) => values.map((value) => Math.round(value * 100) / 100);

describe('a gateway in the browser', () => {
  it('sends what it is given and forgets it when it is acknowledged', async () => {
    const { recorder, store } = await recorderOf();
    await feed(recorder, 0, 600);
    await vi.waitFor(() => expect(service.stored.size).toBe(100));
    await vi.waitFor(async () => expect(await store.count('s')).toBe(0));
    expect(near(received())).toEqual(all(600));
    expect(service.duplicates).toBe(0);
    expect([...service.stored.values()].some((one) => one.isBackfilled)).toBe(false);
    expect(service.hellos[0]).toMatchObject({ placements: ['upper_arm_right'], rate_hz: 60, ticket: 'ticket' });
    await recorder.close();
  });

  it('keeps everything while the link is broken, and sends it afterwards marked back-filled, before anything new', async () => {
    const { recorder, store } = await recorderOf();
    await feed(recorder, 0, 300);
    await vi.waitFor(async () => expect(await store.count('s')).toBe(0));
    service.breakLink();
    await feed(recorder, 300, 900);
    await vi.waitFor(async () => expect(await store.count('s')).toBe(100));
    expect(recorder.state.waiting).toBe(100);
    expect(recorder.state.link.status).toBe('lost');
    service.isReachable = true;
    await vi.waitFor(() => expect(service.hellos.length).toBe(2), 5000);
    await feed(recorder, 900, 1200);
    await vi.waitFor(() => expect(service.stored.size).toBe(200));
    await vi.waitFor(async () => expect(await store.count('s')).toBe(0));
    expect(near(received())).toEqual(all(1200));
    const late = [...service.stored.values()].filter((one) => one.isBackfilled).map((one) => one.sequence);
    expect(late).toEqual(all(100).map((n) => n + 50));
    expect([...service.stored.keys()]).toEqual(all(200));
    await recorder.close();
  });

  it('sends again what the service misses', async () => {
    service.drop = new Set([3, 4, 17]);
    const { recorder, store } = await recorderOf();
    await feed(recorder, 0, 300);
    await vi.waitFor(async () => expect(await store.count('s')).toBe(0), 3000);
    expect(near(received())).toEqual(all(300));
    expect(recorder.state.link.resent).toBe(3);
    await recorder.close();
  });

  it('loses nothing when the page is loaded again without a link', async () => {
    const first = await recorderOf();
    await feed(first.recorder, 0, 300);
    await vi.waitFor(async () => expect(await first.store.count('s')).toBe(0));
    service.breakLink();
    await feed(first.recorder, 300, 600);
    await first.recorder.close();
    first.store.close();

    const { recorder, store } = await recorderOf();
    expect(await store.count('s')).toBe(50);
    await feed(recorder, 600, 900);
    await vi.waitFor(async () => expect(await store.count('s')).toBe(100));
    service.isReachable = true;
    await vi.waitFor(() => expect(service.stored.size).toBe(150), 5000);
    expect(near(received())).toEqual(all(900));
    expect(service.duplicates).toBe(0);
    await recorder.close();
  });

  it('says goodbye when all is sent, and ends with the session', async () => {
    const { recorder, store } = await recorderOf();
    await feed(recorder, 0, 63);
    expect(recorder.state.isComplete).toBe(false);
    recorder.add(0, 1063 * STEP_MS, sample(63));
    const finished = recorder.finish(true);
    expect(recorder.state.isComplete).toBe(false);
    await finished;
    expect(recorder.state).toMatchObject({ isComplete: true, stored: 12 });
    await vi.waitFor(() => expect(recorder.state.link.status).toBe('ended'));
    expect(service.goodbye).toBe(11);
    expect(near(received())).toEqual(all(64));
    expect(await store.count('s')).toBe(0);
  });

  it('connects once, whatever happens while a ticket is on its way', async () => {
    const pending: (() => void)[] = [];
    service.ticket = () => new Promise((resolve) => pending.push(() => resolve('ticket')));
    const { recorder, store } = await recorderOf();
    await feed(recorder, 0, 60);
    expect(pending).toHaveLength(1);
    // A pause so long that the service wants a new hello: another ticket is asked for while the first is on its way.
    const later = 60_000 / STEP_MS;
    recorder.add(0, (1060 + later) * STEP_MS, sample(60));
    await vi.waitFor(() => expect(pending).toHaveLength(2));
    for (const answer of pending) answer();
    await vi.waitFor(async () => expect(await store.count('s')).toBe(0));
    expect(service.sockets).toHaveLength(1);
    expect(service.hellos).toHaveLength(1);
    expect(service.duplicates).toBe(0);
    expect(recorder.state.link.connections).toBe(1);
    await recorder.close();
  });

  it('is not open again when the link breaks while what is safe is forgotten', async () => {
    const { recorder, store } = await recorderOf();
    await feed(recorder, 0, 60);
    const forget = store.forget.bind(store);
    let isCut = false;
    vi.spyOn(store, 'forget').mockImplementation(async (...given) => {
      await forget(...given);
      // An acknowledgement on its way may be of fewer than are stored: the link breaks with the last one.
      if (service.stored.size === 10 && !isCut && (await store.count('s')) === 0) {
        isCut = true;
        service.breakLink();
      }
    });
    await vi.waitFor(() => expect(isCut).toBe(true));
    await vi.waitFor(async () => expect(await store.count('s')).toBe(0));
    expect(recorder.state.link.status).toBe('lost');
    await recorder.close();
  });

  it('says that this device is full, and sends on', async () => {
    const { recorder, store } = await recorderOf();
    const put = vi.spyOn(store, 'put').mockRejectedValue(new DOMException('', 'QuotaExceededError'));
    await feed(recorder, 0, 60);
    await vi.waitFor(() => expect(recorder.state.lostPackets).toBe(10));
    expect(recorder.state.isFull).toBe(true);
    put.mockRestore();
    await feed(recorder, 60, 120);
    await vi.waitFor(() => expect(service.stored.size).toBe(10));
    expect(recorder.state.isFull).toBe(false);
    await recorder.close();
  });

  it('shows what is stored on this device to nobody but the account that recorded it', async () => {
    const { store } = await recorderOf();
    expect(await store.sessions('a')).toHaveLength(1);
    expect(await store.sessions('somebody else')).toEqual([]);
  });

  it('tells a network that refuses the socket from one that is away', async () => {
    const cut = () => {
      const socket = { close: () => undefined, onclose: null as (() => void) | null };
      setTimeout(() => socket.onclose?.());
      return socket as unknown as WebSocket;
    };
    const { create } = service;
    service.create = () => cut();
    const { recorder, store } = await recorderOf();
    await feed(recorder, 0, 60);
    await vi.waitFor(() => expect(recorder.state.link).toMatchObject({ status: 'lost', isBlocked: true }));
    expect(await store.count('s')).toBe(10);
    service.isReachable = false;
    await vi.waitFor(() => expect(recorder.state.link).toMatchObject({ status: 'lost', isBlocked: false }));
    service.isReachable = true;
    service.create = create;
    await vi.waitFor(() => expect(recorder.state.link).toMatchObject({ status: 'open', isBlocked: false }));
    expect(recorder.state.link.status).toBe('open');
    await recorder.close();
  });

  it('stops when the service refuses', async () => {
    service.ticket = () => Promise.reject({ code: 'not_allowed', reason: 'No consent.' });
    const { recorder, store } = await recorderOf();
    await feed(recorder, 0, 60);
    await vi.waitFor(() => expect(recorder.state.link).toMatchObject({ status: 'refused', code: 'not_allowed' }));
    await vi.waitFor(async () => expect(await store.count('s')).toBe(10));
  });

  it('sends what lies behind packets of another key, and waits for none of those', async () => {
    const other = await PacketStore.open('B'.repeat(43) + '=', factory);
    for (let sequence = 0; sequence < 120; sequence += 1)
      await other.put(network.sessionId, sequence, new Uint8Array(40));
    other.close();
    const { recorder } = await recorderOf();
    await feed(recorder, 0, 12);
    await vi.waitFor(() => expect(service.stored.size).toBe(2), 2000);
    expect([...service.stored.keys()]).toEqual([120, 121]);
    await vi.waitFor(() => expect(recorder.state.waiting).toBeLessThanOrEqual(2), 2000);
    await recorder.close();
  });
});
