// A sign-in that ended while somebody works: asked for over the page, which stays as it is, and then the request goes on.
import { hasUnsaved } from '../lib/editing/unsaved';

type Settle = (isSame: boolean) => void;
type Show = (done: Settle) => void;

let show: Show | null = null;
let leave: ((account: string) => void) | null = null;
let pending: Promise<boolean> | null = null;
let settle: Settle | null = null;

/** Requests that wait for a sign-in are refused: nobody is there to answer any more. */
export function giveUpSignIn(): void {
  settle?.(false);
}

/** Where the question is shown, and how the page is left to another account; returns how to end that. */
export function showSignInAgain(how: Show, leaveTo: (account: string) => void): () => void {
  show = how;
  leave = leaveTo;
  return () => {
    if (show !== how) return;
    show = null;
    leave = null;
    giveUpSignIn();
  };
}

/** Another account has signed in, here or in another tab: it sees nothing of this page, and nothing is sent in its name. */
export function anotherSignedIn(account: string): void {
  leave?.(account);
  giveUpSignIn();
}

/**
 * Whether the same account has signed in again. Asked once for all requests that wait, whoever began them: the page must not go
 * away below the question. What a page asks for by itself raises the question only while something is not saved: otherwise the
 * page of the sign-in comes.
 */
export function signInAgain(isByHand: boolean): Promise<boolean> {
  if (pending) return pending;
  const ask = show;
  if (!ask || !(isByHand || hasUnsaved())) return Promise.resolve(false);
  pending = new Promise<boolean>((resolve) => {
    settle = (isSame) => {
      pending = null;
      settle = null;
      resolve(isSame);
    };
    ask(settle);
  });
  return pending;
}
