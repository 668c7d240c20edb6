// Another window of this browser measures, and one at a time may.
import { IconAppWindow } from '@tabler/icons-react';
import { useEffect, useState } from 'react';
import { t } from '../i18n';
import { isTurnElsewhere } from './turn';

const LOOK_MS = 2000;

/** Whether another window measures, looked at while this one could begin. */
export function useElsewhere(isAsked: boolean): boolean {
  const [isElsewhere, setElsewhere] = useState(false);
  useEffect(() => {
    if (!isAsked) return;
    const look = () => void isTurnElsewhere().then(setElsewhere, () => setElsewhere(false));
    look();
    const again = setInterval(look, LOOK_MS);
    return () => clearInterval(again);
  }, [isAsked]);
  return isAsked && isElsewhere;
}

export function Elsewhere() {
  return (
    <section className="card home-moment" role="status">
      <div>
        <h2>
          <IconAppWindow size={38} aria-hidden />
          {t('sensors.elsewhere')}
        </h2>
        <p>{t('sensors.elsewhereText')}</p>
      </div>
    </section>
  );
}
