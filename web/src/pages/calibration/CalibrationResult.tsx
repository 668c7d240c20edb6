// What came of a calibration: the score in a word, why, what to do again, which sensor sits wrong.
import { Button, Group } from '@mantine/core';
import { IconAlertTriangle, IconCircleCheck } from '@tabler/icons-react';
import { Fragment } from 'react';
import type { CalibrationMessage } from '../../api/types';
import { FindingFigure } from '../../components/Figures';
import { t, tOr } from '../../i18n';
import { reasonsOf } from '../../lib/calibration';
import { placementLabel } from '../../lib/channels';
import { number, spreadAlone } from '../../lib/format';
import { scoreText } from '../session/live/Calibration';
import './calibration.css';
import './CalibrationResult.css';

function axisName(name: string): string {
  const side = /_(left|right)$/.exec(name)?.[1];
  const words = tOr(`guide.axis.${name.replace(/_(left|right)$/, '')}`, name.replaceAll('_', ' '));
  return side ? t('channel.sided', { name: words, side: t(`side.${side as 'left' | 'right'}`) }) : words;
}

function fieldText(normUt: number, dipDeg: number | null | undefined): string {
  const norm = t('field.norm', { norm: number(normUt) });
  return typeof dipDeg === 'number' ? t('field.withDip', { norm, dip: number(dipDeg) }) : norm;
}

/** The earth's field as each sensor saw it: off the expected it is iron, not the earth. */
function Fields({ fields }: { fields: NonNullable<CalibrationMessage['fields']> }) {
  return (
    <div>
      <p className="strong">{t('field.title')}</p>
      <dl className="facts">
        {fields.map((field) => (
          <Fragment key={field.placement}>
            <dt>{placementLabel(field.placement)}</dt>
            <dd className="number">
              {fieldText(field.norm_ut, field.dip_deg)}
              {field.is_plausible === false && (
                <span className="alert-text">
                  {' '}
                  <IconAlertTriangle size={17} aria-hidden /> {t('field.odd')}
                </span>
              )}
              {typeof field.norm_before_ut === 'number' && (
                <span className="muted small">
                  {' '}
                  {t('field.before', { field: fieldText(field.norm_before_ut, field.dip_before_deg) })}
                </span>
              )}
            </dd>
          </Fragment>
        ))}
      </dl>
      <p className="muted small">{t('field.expected')}</p>
    </div>
  );
}

export function CalibrationResult({
  guide,
  mayAct,
  isBusy,
  onAgain,
  onClose,
}: {
  guide: CalibrationMessage;
  mayAct: boolean;
  isBusy: boolean;
  onAgain: () => void;
  onClose: () => void;
}) {
  const isDone = guide.phase === 'done';
  const isHeading = guide.kind === 'heading_reset';
  const findings = guide.findings ?? [];
  const axes = guide.axes ?? [];
  const { isUnchecked, reasons } = reasonsOf(guide);
  const fields = guide.fields ?? [];
  const toRedo = guide.steps.filter((step) => guide.redo_steps?.includes(step.key));
  const Icon = isDone ? IconCircleCheck : IconAlertTriangle;
  return (
    <section className={findings.length > 0 ? 'card guide' : 'card'} aria-labelledby="guide-result">
      {findings.length > 0 && (
        <div className="guide-picture">
          <FindingFigure findings={findings} />
        </div>
      )}
      <div className="guide-words">
        <div role="status">
          <h2 id="guide-result" className="result-head">
            <Icon size={26} aria-hidden />
            {!isDone
              ? t('guide.redo')
              : isHeading
                ? t('calibration.directionsSet')
                : scoreText(guide.score ?? 0, isUnchecked)}
          </h2>
        </div>
        {isDone && (guide.kind === 'n_pose' || guide.kind === 't_pose') && (
          <p className="muted small">{t('calibration.scoreMeans')}</p>
        )}
        {findings.map((finding) => (
          <p key={finding.text} className="alert-text">
            {finding.text}
          </p>
        ))}
        {(isDone ? reasons : (guide.reasons ?? [])).map((reason) => (
          <p key={reason}>{reason}</p>
        ))}
        {toRedo.length > 0 && <p>{t('guide.redoSteps', { steps: toRedo.map((step) => step.title).join(', ') })}</p>}
        {fields.length > 0 && <Fields fields={fields} />}
        {axes.length > 0 && (
          <details className="as-table">
            <summary>{t('guide.axes')}</summary>
            <table className="plain-table">
              <thead>
                <tr>
                  <th scope="col">{t('guide.movement')}</th>
                  <th scope="col">{t('guide.range')}</th>
                  <th scope="col">{t('guide.sigma')}</th>
                </tr>
              </thead>
              <tbody>
                {axes.map((axis) => (
                  <tr key={axis.name}>
                    <th scope="row">{axisName(axis.name)}</th>
                    <td className="number">{number(axis.range_deg)}°</td>
                    <td className="number">± {spreadAlone(axis.sigma_deg, 1)}°</td>
                  </tr>
                ))}
              </tbody>
            </table>
          </details>
        )}
        {mayAct && (
          <Group>
            <Button variant={isDone ? 'default' : 'filled'} loading={isBusy} onClick={onAgain}>
              {t(isHeading && isDone ? 'calibration.directionsAgain' : 'calibration.again')}
            </Button>
            <Button variant={isDone ? 'filled' : 'default'} onClick={onClose}>
              {isDone ? t('guide.close') : t('guide.otherWay')}
            </Button>
          </Group>
        )}
      </div>
    </section>
  );
}
