// A sign-in that ended while somebody works: asked for over the page, which stays as it is, and then the request goes on.
import { hasUnsaved } from '../lib/editing/unsaved';

type Show = (done: (isSame: boolean) => void) => void;

let show: Show | null = null;
let pending: Promise<boolean> | null = null;

/** Where the question is shown; returns how to end that. */
export function showSignInAgain(how: Show): () => void {
  show = how;
  return () => {
    if (show === how) show = null;
  };
}

/**
 * Whether the same account has signed in again. Asked once for all requests that wait. A question of the page itself asks only
 * while something is not saved: otherwise the page of the sign-in comes.
 */
export function signInAgain(isChange: boolean): Promise<boolean> {
  const ask = show;
  if (!ask || !(isChange || hasUnsaved())) return Promise.resolve(false);
  pending ??= new Promise<boolean>(ask).finally(() => {
    pending = null;
  });
  return pending;
}
