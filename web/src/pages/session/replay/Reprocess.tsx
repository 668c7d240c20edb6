// A stored session once more: with one estimator and its parameters, or with all of them.
import { Button, Group, NumberInput, Switch, TextInput } from '@mantine/core';
import { useQueryClient } from '@tanstack/react-query';
import { useEffect, useState } from 'react';
import { Link } from 'react-router';
import { key } from '../../../api/address';
import { useReprocess, useReprocessAll } from '../../../api/changes';
import { useJob, useSessionJobs } from '../../../api/queries';
import type { Estimator, Result, SessionDetail } from '../../../api/types';
import { RadioCards } from '../../../components/forms/Choice';
import { Problem } from '../../../components/Feedback';
import { t } from '../../../i18n';
import { JobProgress } from '../AnalysisWait';

type Values = Record<string, boolean | number | string>;

/** Every parameter with its unit; only what differs from its default is sent. */
function Parameters({
  estimator,
  values,
  onChange,
}: {
  estimator: Estimator;
  values: Values;
  onChange: (values: Values) => void;
}) {
  const set = (name: string, value: boolean | number | string, initial: unknown) => {
    const next = { ...values };
    if (value === initial || value === '') delete next[name];
    else next[name] = value;
    onChange(next);
  };
  return (
    <details className="as-table">
      <summary>{t('reprocess.parameters', { count: Object.keys(values).length })}</summary>
      <div className="parameter-grid">
        {estimator.parameter_list.map(({ name, label, unit, default: initial }) => {
          const text = unit ? `${label} (${unit})` : label;
          const value = values[name] ?? initial;
          if (typeof initial === 'boolean')
            return (
              <Switch
                key={name}
                label={text}
                checked={Boolean(value)}
                onChange={(event) => set(name, event.currentTarget.checked, initial)}
              />
            );
          if (typeof initial === 'number')
            return (
              <NumberInput
                key={name}
                size="sm"
                label={text}
                hideControls
                value={Number(value)}
                onChange={(changed) => set(name, changed === '' ? '' : Number(changed), initial)}
              />
            );
          return (
            <TextInput
              key={name}
              size="sm"
              label={text}
              value={String(value)}
              onChange={(event) => set(name, event.currentTarget.value, initial)}
            />
          );
        })}
      </div>
    </details>
  );
}

function RunAll({ session }: { session: SessionDetail }) {
  const client = useQueryClient();
  const all = useReprocessAll(session.id);
  const ids = new Set((all.data ?? []).map((job) => job.id));
  const jobs = useSessionJobs(session.id, all.data ? 1000 : undefined);
  const own = (jobs.data ?? []).filter((job) => ids.has(job.id));
  const done = own.filter((job) => job.status === 'complete' || job.status === 'failed').length;
  const isOver = all.data !== undefined && done === ids.size;
  useEffect(() => {
    if (done > 0) void client.invalidateQueries({ queryKey: key('sessions', session.id) });
  }, [client, done, session.id]);
  const running = own.find((job) => job.status === 'running') ?? own.find((job) => job.status === 'queued');
  return (
    <div className="stack">
      <p className="muted small">{t('reprocess.allText')}</p>
      {all.error && <Problem error={all.error} />}
      {own
        .filter((job) => job.status === 'failed')
        .map((job) => (
          <JobProgress key={job.id} job={job} />
        ))}
      {running && (
        <>
          <p className="strong" role="status">
            {t('reprocess.allProgress', { done, of: ids.size })}
          </p>
          <JobProgress job={running} />
        </>
      )}
      {isOver && <p role="status">{ids.size === 0 ? t('reprocess.allPresent') : t('reprocess.allDone')}</p>}
      <Group>
        <Button
          variant="default"
          loading={all.isPending}
          disabled={all.data !== undefined && !isOver}
          onClick={() => all.mutate()}
        >
          {t('reprocess.all')}
        </Button>
        {session.results.filter((one) => one.status === 'complete').length > 1 && (
          <Button component={Link} to={`/sessions/${session.id}/estimators`} variant="default">
            {t('differences.open')}
          </Button>
        )}
      </Group>
    </div>
  );
}

export function Reprocess({
  session,
  result,
  estimators,
}: {
  session: SessionDetail;
  result: Result | undefined;
  estimators: readonly Estimator[];
}) {
  const reprocess = useReprocess(session.id);
  const job = useJob(reprocess.data?.id ?? null);
  const [picked, setPicked] = useState<string | null>(null);
  const [values, setValues] = useState<Values>({});
  const chosen =
    estimators.find((one) => one.name === picked) ?? estimators.find((one) => one.name !== result?.orientation);
  const isBusy = job.data?.status === 'queued' || job.data?.status === 'running';
  return (
    <section className="stack" aria-labelledby="again">
      <div>
        <h3 id="again">{t('reprocess.title')}</h3>
        <p className="muted small">{t('reprocess.text')}</p>
      </div>
      <RadioCards
        legend={t('newSession.estimator')}
        value={chosen?.name ?? ''}
        onChange={(name) => {
          setPicked(name);
          setValues({});
        }}
        options={estimators.map((one) => ({ value: one.name, title: one.title, text: one.description }))}
      />
      {chosen && <Parameters key={chosen.name} estimator={chosen} values={values} onChange={setValues} />}
      {reprocess.error && <Problem error={reprocess.error} />}
      {job.data && <JobProgress job={job.data} />}
      {job.data?.status === 'complete' && <p role="status">{t('reprocess.done')}</p>}
      <div>
        <Button
          disabled={!chosen || isBusy}
          loading={reprocess.isPending}
          onClick={() => chosen && reprocess.mutate({ orientation: chosen.name, orientation_parameters: values })}
        >
          {t('reprocess.start')}
        </Button>
      </div>
      <RunAll session={session} />
    </section>
  );
}
