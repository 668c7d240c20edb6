import { Button } from '@mantine/core';
import { useState } from 'react';
import { t } from '../../i18n';
import { date } from '../../lib/format';
import { Notice } from '../Feedback';

const KEY = 'telemotion.secondFactorSince';
const SAID_MS = 28 * 24 * 3600 * 1000;

function isRead(since: string): boolean {
  try {
    return localStorage.getItem(KEY) === since;
  } catch {
    return false;
  }
}

/** Tells in every browser of a person that two-step sign-in was turned on, until it was read there: it may have been another's hand. */
export function SecondFactorSet({ since }: { since: string }) {
  const [isClosed, setClosed] = useState(false);
  if (isClosed || isRead(since) || Date.now() - Date.parse(since) > SAID_MS) return null;
  const close = () => {
    setClosed(true);
    try {
      localStorage.setItem(KEY, since);
    } catch {
      // Said again at the next start.
    }
  };
  return (
    <div className="page page-notice">
      <Notice>
        <p>{t('second.set', { date: date(since) })}</p>
        <Button size="sm" variant="default" mt="xs" onClick={close}>
          {t('second.understood')}
        </Button>
      </Notice>
    </div>
  );
}
