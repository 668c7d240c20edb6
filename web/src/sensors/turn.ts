// One window of a browser measures at a time: two would send for the same arm and take the session from each other.
import { SensorFault } from './source';

const NAME = 'telemotion.measuring';

/** Lets go of this window's turn; null while it has none. */
let release: (() => void) | null = null;

function locks(): LockManager | null {
  // Typed as always there; older browsers and pages without https have none.
  return (navigator as { locks?: LockManager }).locks ?? null;
}

/** Take the turn until `giveUpTurn`. Rejects with a `SensorFault` while another window has it. */
export async function takeTurn(): Promise<void> {
  const manager = locks();
  if (release || !manager) return;
  const isOurs = await new Promise<boolean>((resolve, reject) => {
    manager
      .request(NAME, { ifAvailable: true }, (lock) => {
        if (!lock) return resolve(false);
        return new Promise<void>((done) => {
          release = done;
          resolve(true);
        });
      })
      .catch(reject);
  });
  if (!isOurs) throw new SensorFault('otherWindow');
}

export function giveUpTurn(): void {
  release?.();
  release = null;
}

/**
 * Begin as soon as no other window does work of this name, at the latest when that one is closed; returns what ends it,
 * also before it has begun.
 */
export function inTurn(work: string, begin: () => void): () => void {
  const manager = locks();
  if (!manager) {
    begin();
    return () => undefined;
  }
  const waiting = new AbortController();
  let end = () => undefined as void;
  manager
    .request(`telemotion.${work}`, { signal: waiting.signal }, () => {
      begin();
      return new Promise<void>((done) => {
        end = done;
      });
    })
    // Ended before its turn came.
    .catch(() => undefined);
  return () => {
    waiting.abort();
    end();
  };
}

/** Whether another window measures at this moment. */
export async function isTurnElsewhere(): Promise<boolean> {
  if (release) return false;
  const held = await locks()?.query();
  return held?.held?.some((one) => one.name === NAME) ?? false;
}
