import { useVersion } from '../../api/queries';
import type { Estimator, Exercise, TemplateVersionDetail } from '../../api/types';
import { WeightedSum } from '../../components/WeightedSum';
import { t } from '../../i18n';
import { channelLabel, placementLabel } from '../../lib/channels';
import { date, number } from '../../lib/format';
import { estimatorTitle } from '../../lib/sessions';
import { scoreText } from '../session/live/Calibration';
import { Sheet, type ReportProps } from './Sheet';

interface MethodProps extends ReportProps {
  template: TemplateVersionDetail | null;
  estimators: readonly Estimator[];
  exercise: Exercise | null;
}

/** Sheet 3: how it was measured, how good the data is, how the numbers are meant. */
export function MethodSheet({ session, patient, comparison, template, estimators, exercise }: MethodProps) {
  const version = useVersion().data?.version;
  const result = session.results.find((one) => one.id === (comparison?.result_id ?? session.main_result_id)) ?? null;
  const all = session.packets_stored + session.packets_missing;
  const dropped = (comparison?.repetitions ?? []).filter((one) => !one.repetition.is_kept);
  const gaps = session.events.filter((event) => event.kind === 'gap');
  const lost = session.events.filter((event) => event.kind === 'sensor_lost');
  const slipped = session.events.filter((event) => event.kind === 'sensor_slipped');
  const { text, convention } = exercise?.primary_angle
    ? channelLabel(exercise.primary_angle)
    : { text: '', convention: '' };
  const lines: [string, string][] = [
    [t('details.sensors'), `${session.placements.map(placementLabel).join(', ')}; ${number(session.rate_hz)} Hz`],
    [
      t('details.calibration'),
      session.calibration
        ? [scoreText(session.calibration.score), ...session.calibration.reasons].join(' · ')
        : t('report.noCalibration'),
    ],
    [
      t('report.estimator'),
      result
        ? t('report.estimatorText', {
            title: estimatorTitle(result, estimators),
            version: result.orientation_version,
            pipeline: result.pipeline_version,
            kind: result.kind === 'live' ? t('result.live') : t('result.offline'),
          })
        : '–',
    ],
    [
      t('report.dataLoss'),
      all > 0
        ? t('report.dataLossText', {
            percent: number((100 * session.packets_missing) / all, 1),
            gaps: gaps.length,
            lost: lost.length,
          })
        : t('details.uploaded'),
    ],
    ...(slipped.length > 0
      ? [[t('report.slipped'), slipped.map((event) => event.text).join(' ')] as [string, string]]
      : []),
    [
      t('compare.template'),
      comparison
        ? t('report.templateText', {
            name: comparison.template_name,
            number: template ? number(template.number) : '–',
            date: template ? date(template.created_at, new Date(0)) : '–',
            count: template ? number(template.repetition_count) : '–',
          })
        : t('report.notCompared'),
    ],
    [
      t('progress.count'),
      comparison
        ? t('report.evaluated', { accepted: comparison.repetition_count, all: comparison.repetitions.length })
        : '–',
    ],
    ...(text ? [[t('report.mainAngle'), `${text}: ${convention}`] as [string, string]] : []),
  ];
  return (
    <Sheet
      title={t('report.method')}
      number={comparison && comparison.repetitions.length > 0 ? 3 : 2}
      session={session}
      patient={patient}
      version={version}
    >
      <dl className="paper-method">
        {lines.map(([name, value]) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd>{value}</dd>
          </div>
        ))}
      </dl>
      {dropped.length > 0 && (
        <>
          <h3>{t('report.dropped')}</h3>
          <ul className="paper-findings paper-small">
            {dropped.map((one) => (
              <li key={one.repetition.number}>
                {t('repetition.numbered', { number: one.repetition.number })}: {one.repetition.reason}
              </li>
            ))}
          </ul>
        </>
      )}
      {/* Here is room: it is as long as the therapist made it. */}
      {comparison?.weighted_sum && <WeightedSum sum={comparison.weighted_sum} isPaper />}
      <h3>{t('report.meaning')}</h3>
      <dl className="paper-method">
        {(['spread', 'change', 'band', 'phase', 'sparc', 'angles'] as const).map((word) => (
          <div key={word}>
            <dt>{t(`report.word.${word}`)}</dt>
            <dd>{t(`report.word.${word}.text`)}</dd>
          </div>
        ))}
      </dl>
      <p className="paper-note">{t('report.limits')}</p>
      <p className="paper-note paper-ids">{t('report.ids', { session: session.id, result: result?.id ?? '–' })}</p>
    </Sheet>
  );
}
