// The button that signs out says first what this device has not sent yet.
import { lazy, Suspense, useEffect, useState, type ReactNode } from 'react';
import { wantSignOut } from '../../api/signOut';
import { t } from '../../i18n';

const dialog = () => import('../forms/ConfirmDialog');
const counter = () => import('../../sensors/unsentHere');
const ConfirmDialog = lazy(dialog);
/** Signing out never waits longer for the browser's database. */
const PATIENCE_MS = 1500;
/** After the page itself. */
const PRELOAD_MS = 1000;

async function unsentOf(accountId: string): Promise<number> {
  const none = new Promise<number>((resolve) => setTimeout(() => resolve(0), PATIENCE_MS));
  const counted = counter().then(({ unsentSeconds }) => unsentSeconds(accountId));
  return Promise.race([counted, none]).catch(() => 0);
}

/** What to call when somebody wants to sign out, and the question that it may ask. `measures`: by this device, often. */
export function useSignOut(accountId: string, measures: boolean): [() => void, ReactNode] {
  const [unsentS, setUnsentS] = useState<number | null>(null);
  useEffect(() => {
    if (!measures) return;
    // Something is left where there was no link: what asks must be here before.
    const timer = setTimeout(() => void Promise.all([dialog(), counter()]).catch(() => undefined), PRELOAD_MS);
    return () => clearTimeout(timer);
  }, [measures]);
  const ask = () =>
    void unsentOf(accountId).then((seconds) => {
      if (seconds > 0) setUnsentS(seconds);
      else wantSignOut('asked');
    });
  const question = unsentS !== null && (
    <Suspense fallback={null}>
      <ConfirmDialog
        isOpen
        title={t('signOut.unsent')}
        text={t('signOut.unsentText', { seconds: t('sensors.seconds', { count: Math.max(1, Math.round(unsentS)) }) })}
        confirm={t('action.signOut')}
        isGrave={false}
        onConfirm={() => wantSignOut('asked')}
        onClose={() => setUnsentS(null)}
      />
    </Suspense>
  );
  return [ask, question];
}
