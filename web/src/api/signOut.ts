// Signing out. The cookie is not ours to delete: only the service can end a browser session. A sign-out that is wanted is
// noted here until the service has ended it, and nothing else is asked or shown before that, in any tab.
import { api, ApiError, setCsrfToken } from './client';
import { address } from './address';

const KEY = 'telemotion.signOut';
const PATIENCE_MS = 10_000;

/** A person asked for it, or nobody used the page. */
export type SignOutReason = 'asked' | 'idle';

let here: SignOutReason | null = null;
const listeners = new Set<() => void>();

function note(reason: SignOutReason | null): void {
  here = reason;
  try {
    if (reason) localStorage.setItem(KEY, reason);
    else localStorage.removeItem(KEY);
  } catch {
    // Without storage this tab remembers it while it is open.
  }
  for (const listener of listeners) listener();
}

/** The sign-out that somebody wants and the service has not confirmed. */
export function wantedSignOut(): SignOutReason | null {
  try {
    const stored = localStorage.getItem(KEY);
    if (stored === 'asked' || stored === 'idle') return stored;
    // Another tab has brought it about.
    here = null;
  } catch {
    // As above.
  }
  return here;
}

/** Sign out as soon as the service answers. */
export const wantSignOut = (reason: SignOutReason): void => note(reason);

export function onWantedSignOut(listener: () => void): () => void {
  const heard = (event: StorageEvent) => event.key === KEY && listener();
  listeners.add(listener);
  addEventListener('storage', heard);
  return () => {
    listeners.delete(listener);
    removeEventListener('storage', heard);
  };
}

const isEnded = (error: unknown) =>
  error instanceof ApiError && error.status === 401 && error.code === 'sign_in_required';

/** Have the service end the browser session; rejects while it is not known to have ended. */
export async function endBrowserSession(signal: AbortSignal): Promise<void> {
  const within = new AbortController();
  const giveUp = () => within.abort();
  const timer = setTimeout(giveUp, PATIENCE_MS);
  signal.addEventListener('abort', giveUp);
  try {
    // A page that was opened anew has no token.
    const me = await api.get(address('/api/me'), within.signal);
    setCsrfToken(me.csrf_token, me.account_id);
    await api.post('/api/sign-out', undefined, within.signal);
  } catch (error) {
    if (!isEnded(error)) throw error;
  } finally {
    clearTimeout(timer);
    signal.removeEventListener('abort', giveUp);
  }
  signal.throwIfAborted();
  setCsrfToken('');
  note(null);
}
