// One window measures at a time: each window is a copy of the modules of its own, all share the browser's locks.
import { afterEach, beforeEach, expect, it, vi } from 'vitest';

vi.mock('../../src/sensors/awake', () => ({ keepAwake: () => () => undefined }));

/** The browser's locks, as far as they are asked for: the specification's request with `ifAvailable`, and query. */
class Locks {
  readonly #held = new Set<string>();

  async request(name: string, _: { ifAvailable: true }, work: (lock: object | null) => unknown): Promise<void> {
    await Promise.resolve();
    if (this.#held.has(name)) return void (await work(null));
    this.#held.add(name);
    try {
      await work({ name });
    } finally {
      this.#held.delete(name);
    }
  }

  query = () => Promise.resolve({ held: [...this.#held].map((name) => ({ name })) });
}

const owner = (sessionId: string) => ({ sessionId, accountId: 'a', next: 0 });

async function newWindow() {
  vi.resetModules();
  const { SensorRun } = await import('../../src/sensors/run');
  const { isTurnElsewhere } = await import('../../src/sensors/turn');
  return { SensorRun, isTurnElsewhere };
}

beforeEach(() => {
  Object.defineProperty(navigator, 'locks', { value: new Locks(), configurable: true });
});
afterEach(() => {
  Reflect.deleteProperty(navigator, 'locks');
});

it('refuses a second window until the first one has ended', async () => {
  const first = await newWindow();
  const second = await newWindow();
  const run = await first.SensorRun.withBluetooth(owner('s'), []);
  expect(await second.isTurnElsewhere()).toBe(true);
  expect(await first.isTurnElsewhere()).toBe(false);
  await expect(second.SensorRun.withBluetooth(owner('t'), [])).rejects.toMatchObject({ code: 'otherWindow' });
  expect(second.SensorRun.of('t')).toBeNull();
  run.stop();
  await vi.waitFor(async () => expect(await second.isTurnElsewhere()).toBe(false));
  (await second.SensorRun.withBluetooth(owner('t'), [])).stop();
});

it('lets one window go on with another session, and keeps its turn', async () => {
  const first = await newWindow();
  const second = await newWindow();
  const before = await first.SensorRun.withBluetooth(owner('s'), []);
  const run = await first.SensorRun.withBluetooth(owner('t'), []);
  expect(first.SensorRun.of('s')).toBeNull();
  expect(await second.isTurnElsewhere()).toBe(true);
  // What was ended before gives up nothing that is not its own.
  before.stop();
  expect(await second.isTurnElsewhere()).toBe(true);
  run.stop();
  await vi.waitFor(async () => expect(await second.isTurnElsewhere()).toBe(false));
});

it('measures where the browser has no locks', async () => {
  Reflect.deleteProperty(navigator, 'locks');
  const { SensorRun, isTurnElsewhere } = await newWindow();
  const run = await SensorRun.withBluetooth(owner('s'), []);
  expect(await isTurnElsewhere()).toBe(false);
  run.stop();
});
