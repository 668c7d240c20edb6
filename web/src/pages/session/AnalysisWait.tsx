import { Button, Group, Progress } from '@mantine/core';
import { IconArrowRight } from '@tabler/icons-react';
import { Link } from 'react-router';
import { useSession, useSessionJobs } from '../../api/queries';
import type { Job, SessionDetail, SessionState } from '../../api/types';
import { Problem } from '../../components/Feedback';
import { t } from '../../i18n';
import { kindOf } from '../../kinds';
import { number } from '../../lib/format';

/** One long task: what it does and how far it is. */
export function JobProgress({ job }: { job: Job }) {
  if (job.status === 'failed')
    return <Problem error={new Error(job.message || t('job.failed'))} title={t(`job.${job.kind}`)} />;
  return (
    <div>
      <div className="line-head">
        <span className="strong">{t(`job.${job.kind}`)}</span>
        <span className="muted number">
          {job.status === 'queued' ? t('job.queued') : `${number(100 * job.progress)} %`}
        </span>
      </div>
      <Progress value={100 * job.progress} size="lg" transitionDuration={0} aria-label={t(`job.${job.kind}`)} />
      {job.message && <p className="muted small">{job.message}</p>}
    </div>
  );
}

/** After closing: what is still being worked out, then where to look at it. */
export function AnalysisWait({ session, state }: { session: SessionDetail; state: SessionState }) {
  const isDone = state === 'analysed' || session.state === 'analysed';
  const current = useSession(session.id, isDone ? undefined : 1500);
  const jobs = useSessionJobs(session.id, isDone ? undefined : 1500);
  const ready = isDone || current.data?.state === 'analysed';
  // Sessions without a template end with the same task: nothing is compared there, so nothing is said of it.
  const isCompared = kindOf(session).isCompared && Boolean(session.prescription_id);
  const running = (jobs.data ?? []).filter(
    (job) => job.status !== 'complete' && (isCompared || job.kind !== 'compare' || job.status === 'failed'),
  );
  return (
    <section className="card stack" aria-labelledby="analysis" role="status">
      <h2 id="analysis">{ready ? t('analysis.done') : t('analysis.title')}</h2>
      {running.map((job) => (
        <JobProgress key={job.id} job={job} />
      ))}
      {!ready && <p className="muted">{t('analysis.text')}</p>}
      {ready && (
        <Group>
          <Button
            size="lg"
            component={Link}
            to={`/sessions/${session.id}`}
            rightSection={<IconArrowRight size={19} aria-hidden />}
          >
            {t('live.toReplay')}
          </Button>
          {session.purpose === 'template' && (
            <Button
              size="lg"
              variant="default"
              component={Link}
              to={`/templates/record?session=${session.id}&patient=${session.patient_id}${session.exercise_id ? `&exercise=${session.exercise_id}` : ''}`}
            >
              {t('template.makeFromThis')}
            </Button>
          )}
        </Group>
      )}
    </section>
  );
}
