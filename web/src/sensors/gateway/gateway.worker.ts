// Stores and sends off the page's own thread: drawing never delays a sample, and a slow database never stops the page.
import type { FromWorker, ToWorker } from './messages';
import { Recorder } from './recorder';
import { PacketStore } from './store';

/** The page hears of it so often at most. */
const SAY_MS = 200;

const say = (message: FromWorker) => self.postMessage(message);
const asked = new Map<number, { give: (ticket: string) => void; refuse: (why: unknown) => void }>();
let number = 0;
let recorder: Recorder | null = null;
let timer: ReturnType<typeof setTimeout> | undefined;

function ticket(): Promise<string> {
  number += 1;
  const mine = number;
  return new Promise((give, refuse) => {
    asked.set(mine, { give, refuse });
    say({ type: 'ticket', number: mine });
  });
}

function changed(): void {
  timer ??= setTimeout(() => {
    timer = undefined;
    if (recorder) say({ type: 'state', state: recorder.state });
  }, SAY_MS);
}

async function take(message: ToWorker): Promise<void> {
  switch (message.type) {
    case 'begin': {
      const store = await PacketStore.open(message.key);
      recorder = new Recorder({ network: message.network, url: message.url, store, ticket, onState: changed });
      return recorder.begin();
    }
    case 'sample':
      return recorder?.add(message.sensor, message.timeMs, message.sample);
    case 'leave':
      return recorder?.leave(message.sensor);
    case 'flush':
      return recorder?.flush();
    case 'finish':
      return recorder?.finish(message.isGoodbye);
    case 'close':
      await recorder?.close();
      return self.close();
    case 'ticket':
      asked.get(message.number)?.give(message.ticket);
      asked.delete(message.number);
      return;
    case 'noTicket':
      asked.get(message.number)?.refuse(message.refusal);
      asked.delete(message.number);
  }
}

self.onmessage = (event: MessageEvent<ToWorker>) => {
  take(event.data).catch((error: unknown) =>
    say({ type: 'broken', reason: error instanceof Error ? error.message : String(error) }),
  );
};
