import { Button } from '@mantine/core';
import { t } from '../i18n';

/** A fault of our own: the page cannot go on, the data is safe at the service. */
export function CrashPage() {
  return (
    <main className="page page-narrow">
      <div className="card empty">
        <h1>{t('crash.title')}</h1>
        <p>{t('crash.text')}</p>
        <Button onClick={() => window.location.reload()}>{t('crash.reload')}</Button>
      </div>
    </main>
  );
}
