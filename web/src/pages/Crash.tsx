import { Button } from '@mantine/core';
import { IconPlugConnectedX } from '@tabler/icons-react';
import { useEffect, useState } from 'react';
import { useRouteError } from 'react-router';
import { Empty } from '../components/Feedback';
import { t } from '../i18n';
import { isNotFetched, isServiceThere } from '../lib/browser/pieces';

const AGAIN_MS = 3000;

const reload = () => window.location.reload();

/** The network or the service is away: say so, look for it, and go on by itself when it is back. */
function Offline({ onBack }: { onBack: () => void }) {
  useEffect(() => {
    let isGone = false;
    const look = async () => {
      if ((await isServiceThere()) && !isGone) onBack();
    };
    const timer = setInterval(() => void look(), AGAIN_MS);
    const back = () => void look();
    window.addEventListener('online', back);
    return () => {
      isGone = true;
      clearInterval(timer);
      window.removeEventListener('online', back);
    };
  }, [onBack]);
  return (
    <Empty
      icon={<IconPlugConnectedX size={44} aria-hidden />}
      title={t('offline.title')}
      action={<Button onClick={onBack}>{t('action.tryAgain')}</Button>}
    >
      {t('offline.text')}
    </Empty>
  );
}

/** A page that cannot go on: because a piece of it did not come, or because of a fault of our own. */
export function CrashPage({ onReload = reload }: { onReload?: () => void }) {
  const error = useRouteError();
  // A piece that a newer service no longer has is missing too, though the service answers: then the page is out of date.
  const [isThere, setThere] = useState<boolean | null>(null);
  const isMissing = isNotFetched(error);
  useEffect(() => {
    if (isMissing) void isServiceThere().then(setThere);
  }, [isMissing]);
  return (
    <main className="page page-narrow">
      <div className="card" role="alert">
        {isMissing && isThere === null ? null : isMissing && !isThere ? (
          <Offline onBack={onReload} />
        ) : (
          <Empty
            title={t(isMissing ? 'crash.oldTitle' : 'crash.title')}
            action={<Button onClick={onReload}>{t('crash.reload')}</Button>}
          >
            {t(isMissing ? 'crash.oldText' : 'crash.text')}
          </Empty>
        )}
      </div>
    </main>
  );
}
