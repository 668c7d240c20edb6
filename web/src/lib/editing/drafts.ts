// What somebody typed and did not save, on this device: in the storage of the tab, by account and object. It goes when it is
// saved or discarded, when anybody signs out in this browser, and when another account signs in.
const PREFIX = 'telemotion.draft.';
/** Of all tabs: a sign-out changes it, and drafts of before are no longer read, in a tab that is opened again either. */
const EPOCH = 'telemotion.drafts';

export interface Draft<T> {
  /** When it was last changed, in ms since the epoch. */
  at: number;
  value: T;
}

const keyOf = (account: string, object: string) => `${PREFIX}${account}.${object}`;

/** Without storage, as in some private windows, nothing is stored and nothing fails. */
function withStorage<T>(deed: () => T, otherwise: T): T {
  try {
    return deed();
  } catch {
    return otherwise;
  }
}

const epoch = () => localStorage.getItem(EPOCH) ?? '';

function removeWhere(isWanted: (key: string) => boolean): void {
  withStorage(() => {
    const keys = Array.from({ length: sessionStorage.length }, (_, index) => sessionStorage.key(index));
    for (const key of keys) if (key?.startsWith(PREFIX) && isWanted(key)) sessionStorage.removeItem(key);
  }, undefined);
}

export function writeDraft(account: string, object: string, value: unknown): void {
  withStorage(
    () => sessionStorage.setItem(keyOf(account, object), JSON.stringify({ epoch: epoch(), at: Date.now(), value })),
    undefined,
  );
}

export function readDraft<T>(account: string, object: string): Draft<T> | null {
  return withStorage(() => {
    const stored = JSON.parse(sessionStorage.getItem(keyOf(account, object)) ?? 'null') as
      (Draft<T> & { epoch: string }) | null;
    return stored && stored.epoch === epoch() ? { at: stored.at, value: stored.value } : null;
  }, null);
}

export function removeDraft(account: string, object: string): void {
  withStorage(() => sessionStorage.removeItem(keyOf(account, object)), undefined);
}

/** Nothing that was typed stays, in this tab or any other. */
export function forgetDrafts(): void {
  removeWhere(() => true);
  withStorage(() => localStorage.setItem(EPOCH, `${Date.now()} ${Math.random()}`), undefined);
}

/** Drafts of other accounts than the one that signs in go. */
export function forgetDraftsOfOthers(account: string): void {
  removeWhere((key) => !key.startsWith(`${PREFIX}${account}.`));
}

/** Drafts of before a sign-out go: a browser may open a closed tab again with all that it stored. */
export function pruneDrafts(): void {
  removeWhere((key) =>
    withStorage(() => (JSON.parse(sessionStorage.getItem(key) ?? '{}') as { epoch?: string }).epoch !== epoch(), true),
  );
}
