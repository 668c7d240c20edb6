import { Button, Progress } from '@mantine/core';
import type { StateMessage } from '../../api/types';
import { PoseFigure } from '../../components/Figures';
import { Notice } from '../../components/Feedback';
import { t } from '../../i18n';
import { number } from '../../lib/format';

const GOOD_SCORE = 0.8;
const FAIR_SCORE = 0.5;

export function scoreText(score: number): string {
  const hundred = number(score * 100);
  if (score >= GOOD_SCORE) return t('calibration.good', { score: hundred });
  return score >= FAIR_SCORE ? t('calibration.fair', { score: hundred }) : t('calibration.poor', { score: hundred });
}

/** The guided pose: picture, words, how much is held, and what came of it. */
export function CalibrationGuide({ message, isBusy, mayTreat, onCalibrate }: { message: StateMessage | null; isBusy: boolean; mayTreat: boolean; onCalibrate: () => void }) {
  const progress = message?.calibration_progress ?? null;
  const calibration = message?.calibration ?? null;
  const isHolding = progress !== null && progress < 1;
  return (
    <section className="card calibration" aria-labelledby="calibration">
      <PoseFigure isHeld={calibration !== null && !isHolding} />
      <div className="calibration-words">
        <h2 id="calibration">{isHolding ? t('calibration.hold') : t('calibration.title')}</h2>
        <ol className="calibration-steps">
          <li>{t('calibration.stand')}</li>
          <li>{t('calibration.arms')}</li>
          <li>{t('calibration.still')}</li>
        </ol>
        {isHolding && (
          <>
            <Progress value={100 * (progress ?? 0)} size="xl" transitionDuration={0} aria-label={t('calibration.progress')} />
            <p className="muted">{t('calibration.held', { percent: number(100 * (progress ?? 0)) })}</p>
          </>
        )}
        {message?.calibration_hint && (
          <p className="strong" role="status">
            {message.calibration_hint}
          </p>
        )}
        {calibration && !isHolding && (
          <Notice>
            <p className="strong">{scoreText(calibration.score)}</p>
            {calibration.reasons.map((reason) => (
              <p key={reason}>{reason}</p>
            ))}
          </Notice>
        )}
        {mayTreat && (
          <Button size="lg" onClick={onCalibrate} loading={isBusy} disabled={isHolding} variant={calibration ? 'default' : 'filled'}>
            {calibration ? t('calibration.again') : t('calibration.start')}
          </Button>
        )}
      </div>
    </section>
  );
}
