import { Button, SegmentedControl, TextInput } from '@mantine/core';
import { IconSearch, IconUserPlus, IconUsers } from '@tabler/icons-react';
import { useEffect, useState } from 'react';
import { Link } from 'react-router';
import { useCaseload, useDemonstration } from '../api/queries';
import type { CaseloadRow } from '../api/types';
import { Sparkline } from '../charts/Sparkline';
import { QueryBoundary, Empty, ShowMore } from '../components/Feedback';
import { LiveMark, ReasonMark, SideMark } from '../components/Marks';
import { SeenButton, WorryText } from '../components/Worries';
import { Page } from '../components/Page';
import { useSignedIn } from '../components/account/useSignedIn';
import { t } from '../i18n';
import { day, number, quantity } from '../lib/format';
import { actionPath, matches, type CaseloadFilter } from '../lib/assessment/caseload';
import { fullName } from '../lib/people';
import { ArchivedPatients } from './patient/ArchivedPatients';
import './Caseload.css';

function Practised({ percent }: { percent: number | null }) {
  if (percent === null) return <span className="muted">–</span>;
  return (
    <span className="nowrap">
      <span className="meter" aria-hidden>
        <span style={{ width: `${Math.min(100, percent)}%` }} />
      </span>
      {number(percent)} %
    </span>
  );
}

/** Why to look: the most urgent reason, and the gravest worry that nobody has marked as seen yet. */
function Reason({ row, name }: { row: CaseloadRow; name: string }) {
  const { worry, reason } = row;
  if (reason === '') return row.live_state ? null : <span className="muted">{t('reason.none')}</span>;
  const more = row.worry_count - 1;
  return (
    <>
      {reason !== worry?.kind && (
        <>
          <ReasonMark reason={reason} />
          {row.reason_text && <span className="reason-text">{row.reason_text}</span>}
        </>
      )}
      {worry && (
        <WorryText worry={worry}>
          <p className="worry-actions">
            {row.may_treat && (
              <SeenButton
                patientId={row.patient_id}
                worries={[worry]}
                label={t('worry.seen')}
                name={t('worry.markOf', { what: t(`reason.${worry.kind}`), name })}
              />
            )}
            {more > 0 && (
              <Link to={`/patients/${row.patient_id}`} className="above small">
                {t('worry.more', { count: more })}
              </Link>
            )}
          </p>
        </WorryText>
      )}
    </>
  );
}

function Row({ row }: { row: CaseloadRow }) {
  const name = fullName(row);
  return (
    <tr>
      <td className="who wide">
        <Link to={`/patients/${row.patient_id}`} title={name}>
          <span className="long-name">{name}</span>
        </Link>
        <div>
          <SideMark side={row.affected_side ?? null} />
        </div>
      </td>
      <td className="wide">
        <Reason row={row} name={name} />
        {row.live_session_id && row.live_state && row.reason !== 'link_lost' && (
          <div className="live-now">
            <LiveMark state={row.live_state} />
          </div>
        )}
      </td>
      <td data-label={row.main_measure ?? t('caseload.trend')} className="wide">
        <div className="trend">
          <Sparkline
            values={row.trend}
            days={row.trend_days}
            low={row.trend_low}
            high={row.trend_high}
            unit={row.main_unit ?? null}
            label={row.main_measure ?? ''}
          />
          {row.trend.length > 0 && (
            <span>
              <span className="value number">{quantity(row.trend.at(-1), row.main_unit)}</span>
              <span className="muted small measure-name">{row.main_measure}</span>
            </span>
          )}
        </div>
      </td>
      <td data-label={t('caseload.practised')}>
        <Practised percent={row.adherence_percent ?? null} />
        {(row.pain_stops ?? 0) > 0 && <div className="small">{t('practice.pain', { count: row.pain_stops ?? 0 })}</div>}
      </td>
      <td data-label={t('caseload.last')}>{day(row.last_session_at ?? null)}</td>
      <td data-label={t('caseload.due')} className="due wide">
        {row.due || <span className="muted">{t('caseload.nothingDue')}</span>}
      </td>
      <td className="wide">
        <Button
          component={Link}
          to={actionPath(row)}
          size="sm"
          variant={row.reason === '' && row.action !== 'watch' ? 'default' : 'filled'}
          className="above"
          aria-label={t('caseload.actionOf', { action: t(`caseload.action.${row.action}`), name })}
        >
          {t(`caseload.action.${row.action}`)}
        </Button>
      </td>
    </tr>
  );
}

function Rows({ rows, of }: { rows: CaseloadRow[]; of: ReturnType<typeof useCaseload> }) {
  const [search, setSearch] = useState('');
  const [filter, setFilter] = useState<CaseloadFilter>('all');
  const [seesArchive, setSeesArchive] = useState(false);
  const { hasNextPage, isFetchingNextPage, fetchNextPage } = of;
  // Who needs attention comes first: once somebody without a reason is read, all of them are.
  const mayMoreNeedAttention = hasNextPage && rows.at(-1)?.reason !== '';
  const needsRest =
    hasNextPage &&
    !isFetchingNextPage &&
    !of.isFetchNextPageError &&
    (search !== '' || filter === 'live' || mayMoreNeedAttention);
  useEffect(() => {
    if (needsRest) void fetchNextPage();
  }, [needsRest, fetchNextPage]);
  if (rows.length === 0) {
    return (
      <div className="card">
        <Empty
          icon={<IconUsers size={44} aria-hidden />}
          title={t('caseload.emptyTitle')}
          action={
            <Button component={Link} to="/patients/new">
              {t('patient.add')}
            </Button>
          }
        >
          {t('caseload.emptyText')}
        </Empty>
        {seesArchive ? (
          <ArchivedPatients />
        ) : (
          <Button variant="subtle" size="sm" onClick={() => setSeesArchive(true)}>
            {t('caseload.archivedSeen')}
          </Button>
        )}
      </div>
    );
  }
  const shown = rows.filter((row) => matches(row, filter, search));
  const count = (one: CaseloadFilter) => {
    const isSure = one === 'look' ? !mayMoreNeedAttention : !hasNextPage;
    return `${rows.filter((row) => matches(row, one, '')).length}${isSure ? '' : '+'}`;
  };
  return (
    <>
      <div className="caseload-tools">
        <TextInput
          className="search"
          aria-label={t('caseload.search')}
          placeholder={t('caseload.search')}
          leftSection={<IconSearch size={19} aria-hidden />}
          value={search}
          onChange={(event) => setSearch(event.currentTarget.value)}
        />
        <SegmentedControl
          size="md"
          aria-label={t('caseload.filter')}
          value={seesArchive ? 'archived' : filter}
          onChange={(value) => {
            setSeesArchive(value === 'archived');
            if (value !== 'archived') setFilter(value as CaseloadFilter);
          }}
          data={[
            ...(['all', 'look', 'live'] as const).map((value) => ({
              value,
              label: `${t(`caseload.filter.${value}`)} (${count(value)})`,
            })),
            { value: 'archived', label: t('caseload.filter.archived') },
          ]}
        />
      </div>
      <p className="visually-hidden" role="status">
        {seesArchive ? '' : t('caseload.shown', { count: shown.length })}
      </p>
      {seesArchive ? (
        <ArchivedPatients search={search} />
      ) : shown.length === 0 ? (
        <div className="card">
          <Empty title={t('caseload.noMatchTitle')}>{t('caseload.noMatchText')}</Empty>
        </div>
      ) : (
        <table className="caseload">
          <thead>
            <tr>
              <th scope="col">{t('caseload.patient')}</th>
              <th scope="col">{t('caseload.reason')}</th>
              <th scope="col">{t('caseload.trend')}</th>
              <th scope="col">{t('caseload.practised')}</th>
              <th scope="col">{t('caseload.last')}</th>
              <th scope="col">{t('caseload.due')}</th>
              <th scope="col">{t('caseload.next')}</th>
            </tr>
          </thead>
          <tbody>
            {shown.map((row) => (
              <Row key={row.patient_id} row={row} />
            ))}
          </tbody>
        </table>
      )}
      {!seesArchive && <ShowMore of={of} />}
    </>
  );
}

function PastSessions() {
  const { data } = useDemonstration();
  if (!data) return null;
  return (
    <p className="banner banner-note" role="status">
      {t('caseload.preparing', { prepared: data.prepared, total: data.total })}
    </p>
  );
}

export function CaseloadPage() {
  const me = useSignedIn();
  const caseload = useCaseload();
  const waiting = caseload.data?.filter((row) => matches(row, 'look', '')).length;
  return (
    <Page
      title={t('caseload.title')}
      lead={
        waiting === undefined
          ? me.clinic_name
          : waiting === 0
            ? t('caseload.leadNobody')
            : t('caseload.lead', { count: waiting })
      }
      actions={
        <Button
          component={Link}
          to="/patients/new"
          variant="default"
          leftSection={<IconUserPlus size={19} aria-hidden />}
        >
          {t('patient.add')}
        </Button>
      }
    >
      <PastSessions />
      <QueryBoundary of={caseload} lines={8} height={44}>
        {(rows) => <Rows rows={rows} of={caseload} />}
      </QueryBoundary>
    </Page>
  );
}
