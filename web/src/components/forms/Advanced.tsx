import type { ReactNode } from 'react';
import { t } from '../../i18n';

/** What few people change, closed below the questions that everybody answers. */
export function Advanced({ children }: { children: ReactNode }) {
  return (
    <details className="as-table">
      <summary>{t('form.advanced')}</summary>
      <div className="stack advanced">{children}</div>
    </details>
  );
}
