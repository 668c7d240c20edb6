// Which session this page measures for, known without loading what measures.
import type { Measuring } from './rest';

let measuring: Measuring | null = null;

export function setMeasuring(one: Measuring | null): void {
  const before = measuring;
  measuring = one;
  // One at a time: what measured before ends.
  if (one) before?.stop();
}

export function isMeasuring(): boolean {
  return measuring !== null;
}

export function measuringFor(sessionId: string): Measuring | null {
  return measuring?.sessionId === sessionId ? measuring : null;
}

const SETTLED_MS = 20_000;

/**
 * Before a session is ended: wait until what this device has measured for it is sent, by this window, by another one or
 * by one that is gone; false when some of it is not.
 */
export async function sendRest(sessionId: string): Promise<boolean> {
  const own = measuringFor(sessionId);
  if (own) return own.settled(SETTLED_MS);
  const { sendRestElsewhere } = await import('./rest');
  return sendRestElsewhere(sessionId, SETTLED_MS);
}

/** Whoever signed in measures no longer: what comes next would be sent in somebody else's name. */
export function stopMeasuring(): void {
  measuring?.stop();
  measuring = null;
}
