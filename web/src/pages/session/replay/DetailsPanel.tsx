import { Button, Select } from '@mantine/core';
import { IconDownload } from '@tabler/icons-react';
import { useNavigate, useSearchParams } from 'react-router';
import { address, ofSession } from '../../../api/address';
import { useDeleteSession } from '../../../api/changes';
import { useEstimators } from '../../../api/queries';
import type { Estimator, Result, SessionDetail } from '../../../api/types';
import { Confirm } from '../../../components/forms/Confirm';
import { Problem } from '../../../components/Feedback';
import { kindOf } from '../../../kinds';
import { t } from '../../../i18n';
import { placementLabel } from '../../../lib/channels';
import { dateTime, duration, number } from '../../../lib/format';
import { estimatorTitle } from '../../../lib/sessions';
import { scoreText } from '../live/Calibration';
import { MoveSession } from './MoveSession';
import { Reprocess } from './Reprocess';

/** What made a result, so that two of them are never mixed up. */
export function resultLabel(result: Result, isMain: boolean, estimators: readonly Estimator[]): string {
  const title = estimatorTitle(result, estimators);
  const kind = result.kind === 'live' ? t('result.live') : t('result.offline');
  const name = t('result.label', { kind, estimator: title, version: result.orientation_version });
  return isMain ? `${name}, ${t('result.main')}` : name;
}

/** How the session was made and with what, and how to estimate it again. */
export function DetailsPanel({ session, resultId }: { session: SessionDetail; resultId: string }) {
  const navigate = useNavigate();
  const estimators = useEstimators();
  const remove = useDeleteSession();
  const result = session.results.find((one) => one.id === resultId);
  const choices = estimators.data ?? [];
  const all = session.packets_stored + session.packets_missing;
  const [, setSearch] = useSearchParams();
  const complete = session.results.filter((one) => one.status === 'complete');
  return (
    <div className="stack">
      {complete.length > 1 && (
        <Select
          label={t('replay.result')}
          size="sm"
          maw={700}
          allowDeselect={false}
          value={resultId}
          onChange={(value) =>
            setSearch(
              (now) => (value ? now.set('result', value) : now.delete('result'), now.delete('comparison'), now),
              { replace: true },
            )
          }
          data={complete.map((one) => ({
            value: one.id,
            label: resultLabel(one, one.id === session.main_result_id, choices),
          }))}
        />
      )}
      <dl className="facts">
        <dt>{t('details.recorded')}</dt>
        <dd>{dateTime(session.started_at ?? session.created_at)}</dd>
        <dt>{t('details.length')}</dt>
        <dd>{duration(session.duration_s)}</dd>
        <dt>{t('details.sensors')}</dt>
        <dd>
          {session.placements.map(placementLabel).join(', ')} · {number(session.rate_hz)} Hz
        </dd>
        <dt>{t('details.packets')}</dt>
        <dd>
          {all > 0
            ? t('details.packetsText', {
                stored: number(session.packets_stored),
                missing: number(session.packets_missing),
              })
            : t('details.uploaded')}
        </dd>
        {session.calibration && (
          <>
            <dt>{t('details.calibration')}</dt>
            <dd>
              {scoreText(session.calibration.score)}
              {session.calibration.reasons.map((reason) => (
                <span key={reason} className="muted small reason-line">
                  {reason}
                </span>
              ))}
            </dd>
          </>
        )}
        <dt>{t('details.results')}</dt>
        <dd>
          <ul className="plain-list">
            {session.results.map((one) => (
              <li key={one.id}>
                {resultLabel(one, one.id === session.main_result_id, choices)}{' '}
                <span className="muted small">{dateTime(one.created_at)}</span>
                {one.status === 'failed' && <span className="alert-text small"> {one.message || t('job.failed')}</span>}
              </li>
            ))}
          </ul>
        </dd>
      </dl>
      {session.may_treat && kindOf(session).hasEstimators && (
        <Reprocess session={session} result={result} estimators={choices} />
      )}
      <div className="details-foot">
        <Button
          component="a"
          href={address('/api/sessions/{session_id}/raw', ofSession(session.id))}
          download
          variant="default"
          leftSection={<IconDownload size={18} aria-hidden />}
        >
          {t('details.raw')}
        </Button>
        {session.may_treat && <MoveSession session={session} />}
        {session.may_treat && (
          <Confirm
            label={t('details.delete')}
            title={t('details.deleteTitle')}
            text={t('details.deleteText')}
            isGrave
            confirm={t('details.delete')}
            onConfirm={() =>
              remove.mutate(session, { onSuccess: () => void navigate(`/patients/${session.patient_id}`) })
            }
          />
        )}
      </div>
      {remove.error && <Problem error={remove.error} />}
    </div>
  );
}
