// What a page says when it waits, finds nothing, or fails: always what happened and what to do.
import { Button, Skeleton } from '@mantine/core';
import { IconAlertTriangle, IconInfoCircle } from '@tabler/icons-react';
import type { ReactNode } from 'react';
import { ApiError } from '../api/client';
import { t, tOr } from '../i18n';

/** Beneath the service's words: what can be done. No right helps where a consent is missing or the patient is archived. */
function adviceOn({ code, details }: ApiError): string {
  if (code === 'not_allowed' && ('purpose' in details || 'archived' in details)) return '';
  return tOr(`problem.${code}`, '');
}

/** The service's words, and beneath them what can be done. */
export function Problem({ error, onRetry, title }: { error: unknown; onRetry?: () => void; title?: string }) {
  const message = error instanceof Error ? error.message : t('problem.unknown');
  const advice = error instanceof ApiError ? adviceOn(error) : '';
  return (
    <div className="problem" role="alert">
      <IconAlertTriangle size={22} aria-hidden />
      <div>
        {title && <p className="strong">{title}</p>}
        <p>{message}</p>
        {advice && advice !== message && <p className="small">{advice}</p>}
        {onRetry && (
          <Button variant="default" size="sm" mt={10} onClick={onRetry}>
            {t('action.tryAgain')}
          </Button>
        )}
      </div>
    </div>
  );
}

/** Something worth knowing that needs no hand. */
export function Notice({ children, icon }: { children: ReactNode; icon?: ReactNode }) {
  return (
    <div className="notice">
      {icon ?? <IconInfoCircle size={22} aria-hidden />}
      <div>{children}</div>
    </div>
  );
}

/** Nothing here yet, and what to do next. */
export function Empty({
  icon,
  title,
  children,
  action,
  level = 2,
}: {
  icon?: ReactNode;
  title: string;
  children?: ReactNode;
  action?: ReactNode;
  level?: 2 | 3;
}) {
  const Heading = level === 2 ? 'h2' : 'h3';
  return (
    <div className="empty">
      {icon}
      <Heading>{title}</Heading>
      {children && <p>{children}</p>}
      {action}
    </div>
  );
}

/** Grey lines where text will be. */
export function Waiting({ lines = 4, height = 22 }: { lines?: number; height?: number }) {
  return (
    <div role="status">
      <span className="visually-hidden">{t('state.loading')}</span>
      {Array.from({ length: lines }, (_, line) => (
        <Skeleton key={line} height={height} mb={14} width={`${100 - ((line * 17) % 40)}%`} animate={false} />
      ))}
    </div>
  );
}

interface Paged {
  hasNextPage: boolean;
  isFetchingNextPage: boolean;
  isFetchNextPageError: boolean;
  error: unknown;
  fetchNextPage: () => unknown;
}

/** The way to the next page of a list, while there is one. */
export function ShowMore({ of }: { of: Paged }) {
  if (!of.hasNextPage) return null;
  return (
    <div className="show-more">
      {of.isFetchNextPageError && <Problem error={of.error} />}
      <Button
        mt={14}
        variant="default"
        size="sm"
        loading={of.isFetchingNextPage}
        onClick={() => void of.fetchNextPage()}
      >
        {t('action.showMore')}
      </Button>
    </div>
  );
}

interface Asked<T> {
  data: T | undefined;
  error: unknown;
  refetch: () => unknown;
}

/** One question to the service: waiting, failed, or its answer. */
export function QueryBoundary<T>({
  of,
  children,
  lines,
  height,
}: {
  of: Asked<T>;
  children: (data: T) => ReactNode;
  lines?: number;
  height?: number;
}) {
  if (of.data !== undefined) return <>{children(of.data)}</>;
  if (of.error) return <Problem error={of.error} onRetry={() => void of.refetch()} />;
  return <Waiting lines={lines} height={height} />;
}
