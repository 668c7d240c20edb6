import { useEffect } from 'react';
import { IconArchive } from '@tabler/icons-react';
import { Link } from 'react-router';
import { useArchivedPatients } from '../../api/queries';
import { QueryBoundary, Empty, ShowMore } from '../../components/Feedback';
import { t } from '../../i18n';
import { holdsWords } from '../../lib/assessment/caseload';
import { date } from '../../lib/format';
import { fullName } from '../../lib/people';

/** Who was taken off the caseload; the patient's page has the way back. */
export function ArchivedPatients({ search = '' }: { search?: string }) {
  const patients = useArchivedPatients();
  const { hasNextPage, isFetchingNextPage, fetchNextPage } = patients;
  const looksForMore = search !== '' && hasNextPage && !isFetchingNextPage;
  useEffect(() => {
    if (looksForMore) void fetchNextPage();
  }, [looksForMore, fetchNextPage]);
  return (
    <div className="card">
      <QueryBoundary of={patients} lines={3}>
        {(list) => {
          const shown = list.filter((one) => holdsWords(fullName(one), search));
          return shown.length === 0 ? (
            <Empty
              icon={<IconArchive size={44} aria-hidden />}
              title={list.length === 0 ? t('caseload.archivedNone') : t('caseload.noMatchTitle')}
            />
          ) : (
            <ul className="plain-list lines">
              {shown.map((one) => (
                <li key={one.id}>
                  <Link to={`/patients/${one.id}`} className="strong">
                    {one.given_name} {one.family_name}
                  </Link>
                  <div className="muted small">{t('caseload.archivedOn', { date: date(one.archived_at ?? '') })}</div>
                </li>
              ))}
            </ul>
          );
        }}
      </QueryBoundary>
      <ShowMore of={patients} />
    </div>
  );
}
