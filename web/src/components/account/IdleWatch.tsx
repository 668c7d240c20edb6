// Warns before a browser that nobody uses is signed out, says so when it was, and keeps one signed in that is used.
import { useEffect, useState } from 'react';
import { address } from '../../api/address';
import { api } from '../../api/client';
import { wantSignOut } from '../../api/signOut';
import { t } from '../../i18n';
import { idleSeconds, listenForUse } from '../../lib/browser/idle';
import './IdleWatch.css';

const LOOK_EVERY_MS = 5000;
const WARN_S = 120;
const REPORT_EVERY_S = 60;

/** The service notes use at a quarter of the limit. */
const reportEveryS = (minutes: number) => Math.min(REPORT_EVERY_S, minutes * 15);

export function IdleWatch({ minutes }: { minutes: number }) {
  const [leftS, setLeftS] = useState<number | null>(null);
  useEffect(() => {
    const stop = listenForUse(window);
    let reportedAt = Date.now();
    const look = () => {
      const idleS = idleSeconds();
      const untilS = minutes * 60 - idleS;
      setLeftS(untilS <= Math.min(WARN_S, minutes * 30) ? Math.max(0, untilS) : null);
      if (untilS <= 0) {
        wantSignOut('idle');
      } else if (idleS < reportEveryS(minutes) && Date.now() - reportedAt > reportEveryS(minutes) * 1000) {
        // Watching asks for nothing over HTTP: without this, a page in use would end like one that is not.
        reportedAt = Date.now();
        void api.get(address('/api/me')).catch(() => undefined);
      }
    };
    const timer = setInterval(look, LOOK_EVERY_MS);
    window.addEventListener('pointerdown', look);
    window.addEventListener('keydown', look);
    return () => {
      stop();
      clearInterval(timer);
      window.removeEventListener('pointerdown', look);
      window.removeEventListener('keydown', look);
    };
  }, [minutes]);
  if (leftS === null) return null;
  return (
    <div className="idle-warning" role="alert">
      <p>{t('idle.warning', { minutes })}</p>
    </div>
  );
}
