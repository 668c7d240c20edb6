import { Button } from '@mantine/core';
import { IconAlertTriangle } from '@tabler/icons-react';
import { ApiError } from '../../api/client';
import { t, type Key } from '../../i18n';

const WORDS: Record<number, Key & `home.problem.${string}`> = {
  0: 'home.problem.offline',
  403: 'home.problem.notAllowed',
  404: 'home.problem.gone',
  409: 'home.problem.notNow',
  503: 'home.problem.offline',
};

/** What went wrong and what to do, for a patient: the service's own words are made for who knows its parts. */
export function PlainProblem({ error, onRetry }: { error: unknown; onRetry?: () => void }) {
  return (
    <div className="problem" role="alert">
      <IconAlertTriangle size={26} aria-hidden />
      <div>
        <p>{t((error instanceof ApiError && WORDS[error.status]) || 'home.problem.other')}</p>
        {onRetry && (
          <Button variant="default" mt={10} onClick={onRetry}>
            {t('action.tryAgain')}
          </Button>
        )}
      </div>
    </div>
  );
}
