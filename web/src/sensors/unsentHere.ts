// What an account has measured on this device that is not sent yet: counted at sign-out, without reading any of it.
import { PacketStore } from './gateway/store';

/** A packet is about a tenth of a second of movement (`docs/browser-sensors.md`). */
const SECONDS_A_PACKET = 0.1;

/** Seconds of movement; 0 where nothing waits. */
export async function unsentSeconds(accountId: string): Promise<number> {
  if (typeof indexedDB === 'undefined') return 0;
  const store = await PacketStore.open('');
  let packets = 0;
  for (const sessionId of await store.sessions(accountId)) packets += await store.count(sessionId);
  store.close();
  return packets * SECONDS_A_PACKET;
}

/** Delete what nobody has sent for weeks, whoever measured it: nobody has to be signed in. */
export async function forgetOld(): Promise<void> {
  if (typeof indexedDB === 'undefined') return;
  const store = await PacketStore.open('');
  await store.removeOld();
  store.close();
}
