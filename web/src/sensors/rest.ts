// Before a session ends, all that any window of this device has measured for it is sent: windows ask each other.
import { BrowserGateway } from './gateway/browserGateway';
import { hasCryptography, heldStoreKey } from './gateway/seal';
import { PacketStore } from './gateway/store';
import { isTurnElsewhere } from './turn';

/** What this window measures for a session, whose rest can be asked for. */
export interface Measuring {
  sessionId: string;
  /** Resolves when all that was measured is safe with the service, or the time is over; says whether it is. */
  settled: (withinMs: number) => Promise<boolean>;
  stop: () => void;
}

const NAME = 'telemotion.rest';
/** A window that measures says at once that it has heard. */
const HEARD_MS = 1500;
const LOOK_MS = 200;

type Said =
  | { kind: 'ask'; sessionId: string; number: string; withinMs: number }
  | { kind: 'heard'; number: string }
  | { kind: 'answer'; number: string; isSafe: boolean };

/** Let other windows ask that this one sends the rest of its session; returns what ends that. */
export function answerOthers(one: Measuring): () => void {
  if (typeof BroadcastChannel === 'undefined') return () => undefined;
  const channel = new BroadcastChannel(NAME);
  let isClosed = false;
  channel.onmessage = ({ data }: MessageEvent<Said>) => {
    if (data.kind !== 'ask' || data.sessionId !== one.sessionId) return;
    channel.postMessage({ kind: 'heard', number: data.number } satisfies Said);
    void one.settled(data.withinMs).then((isSafe) => {
      if (!isClosed) channel.postMessage({ kind: 'answer', number: data.number, isSafe } satisfies Said);
    });
  };
  return () => {
    isClosed = true;
    channel.close();
  };
}

/** What the window that measures for a session says: whether all is sent; null where there is none. */
function askOthers(sessionId: string, withinMs: number): Promise<boolean | null> {
  if (typeof BroadcastChannel === 'undefined') return Promise.resolve(null);
  const channel = new BroadcastChannel(NAME);
  const number = `${Date.now()}.${Math.random()}`;
  return new Promise<boolean | null>((resolve) => {
    let giveUp = setTimeout(() => resolve(null), HEARD_MS);
    channel.onmessage = ({ data }: MessageEvent<Said>) => {
      if (data.kind === 'ask' || data.number !== number) return;
      clearTimeout(giveUp);
      if (data.kind === 'answer') resolve(data.isSafe);
      else giveUp = setTimeout(() => resolve(false), withinMs + HEARD_MS);
    };
    channel.postMessage({ kind: 'ask', sessionId, number, withinMs } satisfies Said);
  }).finally(() => channel.close());
}

/** Counted without the key: where nothing is left, nobody needs it. */
async function countHere(sessionId: string): Promise<number> {
  const store = await PacketStore.open('');
  const left = await store.count(sessionId);
  store.close();
  return left;
}

/** Send what lies on this device for a session that nobody measures for any more; says whether nothing is left. */
async function sendStored(sessionId: string, withinMs: number): Promise<boolean> {
  // A page without https measures nothing and has no cryptography: nothing was ever stored there.
  if (typeof indexedDB === 'undefined' || !hasCryptography()) return true;
  if ((await countHere(sessionId)) === 0) return true;
  const store = await PacketStore.open(heldStoreKey());
  const network = await store.network(sessionId).catch(() => null);
  const isAnyReadable = (await store.read(sessionId, 0, 1)).length > 0;
  store.close();
  if (network === undefined) return true;
  // It was sealed with a key that nobody has.
  if (network === null) return false;
  // All that could be sent was sent.
  if (!isAnyReadable) return true;
  // A window that does not answer has it, and would be cut off.
  if (await isTurnElsewhere()) return false;
  const gateway = new BrowserGateway(network);
  const isSent = () => {
    const { recorder } = gateway.getSnapshot();
    return recorder !== null && recorder.link.connections > 0 && recorder.waiting === 0;
  };
  const untilMs = performance.now() + withinMs;
  while (!isSent() && performance.now() < untilMs) await new Promise((resolve) => setTimeout(resolve, LOOK_MS));
  gateway.close();
  return isSent();
}

/** Whether all that was measured for a session in other windows of this device, or before, is safe with the service. */
export async function sendRestElsewhere(sessionId: string, withinMs: number): Promise<boolean> {
  return (await askOthers(sessionId, withinMs)) ?? (await sendStored(sessionId, withinMs));
}
