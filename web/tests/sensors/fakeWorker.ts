// The worker of the page's gateway, in the page: jsdom has none. And what a window that is gone has left on the device.
import { vi } from 'vitest';
import type { FromWorker, ToWorker } from '../../src/sensors/gateway/messages';
import { encodePacket, MOTION } from '../../src/sensors/gateway/packet';
import { Recorder } from '../../src/sensors/gateway/recorder';
import { PacketStore, type StoredNetwork } from '../../src/sensors/gateway/store';
import type { FakeService } from './fakeService';

/** Of the account `a` of `tests/pages/render.tsx`. */
export const KEY = 'A'.repeat(43) + '=';

export const NETWORK: StoredNetwork = {
  sessionId: 's',
  accountId: 'a',
  placements: ['upper_arm_right'],
  rateHz: 60,
  device: 'phone',
  next: 0,
};

const TICKS = 6;

/** From now on what gateways send goes to this service. */
export function workWith(service: FakeService) {
  vi.stubGlobal(
    'Worker',
    class {
      onmessage: ((event: { data: FromWorker }) => void) | null = null;
      #recorder: Recorder | null = null;
      readonly #asked = new Map<number, { resolve: (ticket: string) => void; reject: (refusal: object) => void }>();
      postMessage(message: ToWorker) {
        if (message.type === 'begin') void this.#begin(message);
        else if (message.type === 'ticket') this.#asked.get(message.number)?.resolve(message.ticket);
        else if (message.type === 'noTicket') this.#asked.get(message.number)?.reject(message.refusal);
        else if (message.type === 'close') void this.#recorder?.close();
      }
      async #begin({ network, url, key }: Extract<ToWorker, { type: 'begin' }>) {
        const onState = () => {
          if (this.#recorder) this.onmessage?.({ data: { type: 'state', state: this.#recorder.state } });
        };
        const { create } = service;
        const ticket = async () => {
          await service.ticket();
          const number = this.#asked.size;
          return new Promise<string>((resolve, reject) => {
            this.#asked.set(number, { resolve, reject });
            this.onmessage?.({ data: { type: 'ticket', number } });
          });
        };
        const store = await PacketStore.open(key);
        this.#recorder = new Recorder({ network, url, store, ticket, create, random: () => 0, onState });
        await this.#recorder.begin();
      }
    },
  );
}

/** A window that is gone has left packets of a tenth of a second each. */
export async function leavePackets(count: number, network: StoredNetwork = NETWORK, key = KEY): Promise<void> {
  const store = await PacketStore.open(key);
  await store.declare(network);
  for (let sequence = 0; sequence < count; sequence += 1) {
    const bytes = encodePacket({
      sequence,
      deviceTimeUs: BigInt(100_000 * sequence),
      tickIntervalUs: 16_667,
      sensors: 1,
      ticks: TICKS,
      channels: MOTION,
      values: new Float32Array(TICKS * 6).fill(sequence),
    });
    await store.put(network.sessionId, sequence, bytes);
  }
  store.close();
}

/** How many packets of a session are on the device. */
export async function leftOf(sessionId = NETWORK.sessionId): Promise<number> {
  const store = await PacketStore.open('');
  const left = await store.count(sessionId);
  store.close();
  return left;
}
