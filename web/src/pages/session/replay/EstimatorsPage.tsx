// The results of all estimators side by side: how far apart, in which angle, and when.
import { Select } from '@mantine/core';
import { useQueries } from '@tanstack/react-query';
import { useMemo, useState } from 'react';
import { useParams } from 'react-router';
import { ofSession } from '../../../api/address';
import { question, useEstimators, usePatient, useSession } from '../../../api/queries';
import type { Estimator, Result, SessionDetail } from '../../../api/types';
import { LineChart } from '../../../charts/LineChart';
import { QueryBoundary, Empty, Problem, Waiting } from '../../../components/Feedback';
import { Page } from '../../../components/Page';
import { t } from '../../../i18n';
import { channelLabel } from '../../../lib/channels';
import { differenceRows, distinctResults, overallRms } from '../../../lib/assessment/differences';
import { dateTime, number, position } from '../../../lib/format';
import { fullName, patientCrumbs } from '../../../lib/people';
import { estimatorTitle, sessionTitle } from '../../../lib/sessions';
import './replay.css';

function shortLabel(result: Result, estimators: readonly Estimator[]): string {
  const title = estimatorTitle(result, estimators);
  const changed = Object.keys(result.orientation_parameters).length;
  const name = result.kind === 'live' ? t('differences.live', { title }) : title;
  return changed > 0 ? t('differences.changed', { name, count: changed }) : name;
}

const degrees = (value: number | null) => (value === null ? '–' : `${number(value, value < 10 ? 1 : 0)}°`);

function Compared({
  session,
  results,
  estimators,
}: {
  session: SessionDetail;
  results: Result[];
  estimators: readonly Estimator[];
}) {
  const [referenceId, setReference] = useState(
    () => (results.find((one) => one.id === session.main_result_id) ?? results[0])?.id ?? '',
  );
  const reference = results.find((one) => one.id === referenceId);
  const others = results.filter((one) => one.id !== referenceId);
  const asked = useQueries({
    queries: others.map((one) => ({
      ...question('/api/sessions/{session_id}/results/differences', {
        ...ofSession(session.id),
        query: { result_a: one.id, result_b: referenceId, max_points: 800 },
      }),
      staleTime: Infinity,
    })),
  });
  const data = asked.map((one) => one.data);
  const rows = differenceRows(data);
  const [picked, setPicked] = useState<string | null>(null);
  const angle = picked ?? rows[0]?.name ?? null;
  const known = data.map((one) => one?.result_a.id ?? '').join();
  const lines = useMemo(() => {
    if (!angle) return [];
    const first = data.find((one) => one !== undefined);
    const own = first?.curves.find((curve) => curve.name === angle);
    const base =
      first && own && reference ? [{ name: shortLabel(reference, estimators), x: first.time_s, y: own.b_deg }] : [];
    const more = data.flatMap((one) => {
      const curve = one?.curves.find((candidate) => candidate.name === angle);
      return one && curve ? [{ name: shortLabel(one.result_a, estimators), x: one.time_s, y: curve.a_deg }] : [];
    });
    return [...base, ...more];
    // `known` stands for the data: the array is made anew with every picture.
    // eslint-disable-next-line react-hooks/exhaustive-deps
  }, [known, angle, reference, estimators]);
  const error = asked.find((one) => one.error)?.error;
  const worst = data
    .flatMap((one) => one?.angles.filter((candidate) => candidate.name === angle) ?? [])
    .sort((a, b) => (b.maximum_deg ?? 0) - (a.maximum_deg ?? 0))[0];
  return (
    <div className="stack">
      {error && <Problem error={error} />}
      <div className="result-choice">
        <Select
          label={t('differences.reference')}
          size="sm"
          w={380}
          maw="100%"
          data={results.map((one) => ({ value: one.id, label: shortLabel(one, estimators) }))}
          value={referenceId}
          onChange={(value) => value && setReference(value)}
        />
        {angle && (
          <Select
            label={t('differences.angle')}
            size="sm"
            w={380}
            maw="100%"
            data={rows.map((row) => ({ value: row.name, label: channelLabel(row.name).text }))}
            value={angle}
            onChange={(value) => value && setPicked(value)}
          />
        )}
      </div>
      {angle && lines.length > 0 && (
        <section className="card stack" aria-labelledby="curves">
          <h2 id="curves" className="protocol-title">
            {channelLabel(angle).text}
          </h2>
          <LineChart
            lines={lines}
            height={360}
            xTitle={t('differences.time')}
            yTitle={t('differences.degrees')}
            label={t('differences.curves', {
              angle: channelLabel(angle).text,
              lines: lines.map((line) => line.name).join(', '),
            })}
          />
          {worst && typeof worst.maximum_at_s === 'number' && (
            <p className="muted small">
              {t('differences.largest', { degrees: degrees(worst.maximum_deg), at: position(worst.maximum_at_s) })}
            </p>
          )}
        </section>
      )}
      <section className="card stack" aria-labelledby="table">
        <h2 id="table" className="protocol-title">
          {t('differences.table')}
        </h2>
        <p className="muted small">{t('differences.help')}</p>
        {rows.length === 0 ? (
          <Waiting lines={6} />
        ) : (
          // A table that scrolls must be reachable by keyboard.
          // eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex
          <div className="table-scroll" tabIndex={0} role="region" aria-label={t('differences.table')}>
            <table className="plain-table wide-table">
              <thead>
                <tr>
                  <th scope="col">{t('traces.angle')}</th>
                  {others.map((one) => (
                    <th key={one.id} scope="col">
                      {shortLabel(one, estimators)}
                    </th>
                  ))}
                </tr>
              </thead>
              <tbody>
                {rows.map((row) => (
                  <tr key={row.name} className={row.name === angle ? 'row-selected' : undefined}>
                    <th scope="row">{channelLabel(row.name).text}</th>
                    {row.rms.map((value, index) => (
                      <td key={others[index]?.id} className="number">
                        {degrees(value)}
                      </td>
                    ))}
                  </tr>
                ))}
              </tbody>
              <tfoot>
                <tr>
                  <th scope="row">{t('differences.overall')}</th>
                  {data.map((one, index) => (
                    <td key={others[index]?.id} className="number">
                      {degrees(overallRms(one))}
                    </td>
                  ))}
                </tr>
              </tfoot>
            </table>
          </div>
        )}
      </section>
    </div>
  );
}

function Loaded({ session }: { session: SessionDetail }) {
  const estimators = useEstimators();
  const results = distinctResults(session.results, session.main_result_id ?? null);
  if (results.length < 2) return <Empty title={t('differences.emptyTitle')}>{t('differences.emptyText')}</Empty>;
  return (
    <QueryBoundary of={estimators}>
      {(list) => <Compared session={session} results={results} estimators={list} />}
    </QueryBoundary>
  );
}

export function EstimatorsPage() {
  const { sessionId = '' } = useParams();
  const session = useSession(sessionId);
  const patient = usePatient(session.data?.patient_id ?? '');
  const name = patient.data ? fullName(patient.data) : '';
  return (
    <Page
      compact
      title={t('differences.title')}
      lead={session.data ? `${name} · ${dateTime(session.data.started_at ?? session.data.created_at)}` : undefined}
      crumbs={[
        ...patientCrumbs(session.data?.patient_id, name),
        ...(session.data
          ? [{ to: `/sessions/${session.data.id}?show=details`, text: sessionTitle(session.data) }]
          : []),
      ]}
    >
      <QueryBoundary of={session} lines={8} height={40}>
        {(data) => <Loaded session={data} />}
      </QueryBoundary>
    </Page>
  );
}
