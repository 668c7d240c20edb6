// A run is settled when the worker has heard its end and nothing waits, whatever the page heard before.
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import type { FromWorker, ToWorker } from '../../src/sensors/gateway/messages';
import type { RecorderState } from '../../src/sensors/gateway/recorder';
import type { Phone } from '../../src/sensors/phone';
import { SensorRun } from '../../src/sensors/run';

let said: ToWorker[] = [];
let say: (state: Partial<RecorderState>) => void = () => undefined;

beforeEach(() => {
  said = [];
  vi.useFakeTimers();
  vi.stubGlobal(
    'Worker',
    class {
      onmessage: ((event: { data: FromWorker }) => void) | null = null;
      constructor() {
        say = (state) => this.onmessage?.({ data: { type: 'state', state: { link: {}, ...state } as RecorderState } });
      }
      postMessage(message: ToWorker) {
        said.push(message);
      }
    },
  );
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

it('waits for the worker to have taken the last sample', async () => {
  const phone = { rateHz: 60, device: 'phone', stop: vi.fn(), isSilent: () => false };
  const owner = { sessionId: 's', accountId: 'a', next: 0 };
  const run = await SensorRun.withPhone(phone as unknown as Phone, owner, 'upper_arm_right');
  const settled = vi.fn();
  say({ waiting: 0, isComplete: false });
  void run.settled(60_000).then(settled);
  await vi.advanceTimersByTimeAsync(5000);
  expect(phone.stop).toHaveBeenCalledOnce();
  expect(said.at(-1)).toEqual({ type: 'finish', isGoodbye: false });
  expect(settled).not.toHaveBeenCalled();
  say({ waiting: 23, isComplete: true });
  await vi.advanceTimersByTimeAsync(5000);
  expect(settled).not.toHaveBeenCalled();
  say({ waiting: 0, isComplete: true });
  await vi.advanceTimersByTimeAsync(1000);
  expect(settled).toHaveBeenCalledWith(true);
  run.stop();
});
