import { t } from '../../../i18n';
import { number } from '../../../lib/format';

const GOOD_SCORE = 0.8;
const FAIR_SCORE = 0.5;

/** How good a calibration is: a word, and the score for those who compare. */
export function scoreText(score: number, isUnchecked = false): string {
  const hundred = number(score * 100);
  // Of a pose alone nobody knows whether it was right, only whether it was held: that is no good calibration yet.
  if (isUnchecked && score >= FAIR_SCORE) return t('calibration.heldOnly', { score: hundred });
  if (score >= GOOD_SCORE) return t('calibration.good', { score: hundred });
  return score >= FAIR_SCORE ? t('calibration.fair', { score: hundred }) : t('calibration.poor', { score: hundred });
}
