// A wanted sign-out comes before everything: until the service has ended the browser session nothing else is shown.
import { Button } from '@mantine/core';
import { IconAlertTriangle } from '@tabler/icons-react';
import { useQueryClient } from '@tanstack/react-query';
import { useCallback, useEffect, useRef, useState, useSyncExternalStore, type ReactNode } from 'react';
import { forgetEverything } from '../../api/queries';
import { endBrowserSession, onWantedSignOut, wantedSignOut, type SignOutReason } from '../../api/signOut';
import { t } from '../../i18n';

const AGAIN_MS = 5_000;

export function SignedOutFirst({
  children,
  onEnded,
}: {
  children: ReactNode;
  /** Called before the children are shown again. */
  onEnded: (reason: SignOutReason) => void;
}) {
  const wanted = useSyncExternalStore(onWantedSignOut, wantedSignOut);
  return wanted === null ? children : <StillSignedIn reason={wanted} onEnded={onEnded} />;
}

function StillSignedIn({ reason, onEnded }: { reason: SignOutReason; onEnded: (reason: SignOutReason) => void }) {
  const client = useQueryClient();
  const [hasFailed, setFailed] = useState(false);
  const attempt = useRef<AbortController>(undefined);
  const tryNow = useCallback(() => {
    attempt.current?.abort();
    const mine = new AbortController();
    attempt.current = mine;
    // Others are shown as soon as the wish is gone.
    const stopListening = onWantedSignOut(() => wantedSignOut() === null && onEnded(reason));
    endBrowserSession(mine.signal)
      .catch(() => {
        if (mine.signal.aborted) return;
        attempt.current = undefined;
        setFailed(true);
      })
      .finally(stopListening);
  }, [onEnded, reason]);
  useEffect(() => {
    forgetEverything(client);
    document.title = `${t('signOut.still')} · ${t('product.name')}`;
    tryNow();
    const timer = setInterval(() => attempt.current ?? tryNow(), AGAIN_MS);
    addEventListener('online', tryNow);
    return () => {
      clearInterval(timer);
      removeEventListener('online', tryNow);
      attempt.current?.abort();
    };
  }, [client, tryNow]);
  if (!hasFailed) {
    return (
      <main className="page page-narrow">
        <p role="status">{t('signOut.trying')}</p>
      </main>
    );
  }
  return (
    <main className="page page-narrow">
      <div className="problem" role="alert">
        <IconAlertTriangle size={22} aria-hidden />
        <div>
          <h1 className="strong">{t('signOut.still')}</h1>
          <p>{t('signOut.stillText')}</p>
          <Button variant="default" h={44} mt={10} onClick={tryNow}>
            {t('action.tryAgain')}
          </Button>
        </div>
      </div>
    </main>
  );
}
