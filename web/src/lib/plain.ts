// Results in plain words for the patient: a change is told only when it is larger than what repeats by chance.
import type { ProgressMeasure } from '../api/types';
import { t, tOr } from '../i18n';
import { displayUnit, number } from './format';

/** The measure a patient understands best: how far the main joint moved. */
export function mainMeasure(measures: readonly ProgressMeasure[]): ProgressMeasure | null {
  const withPoints = measures.filter((one) => one.points.length > 0);
  return withPoints.find((one) => one.measure.startsWith('range:')) ?? withPoints[0] ?? null;
}

/** One sentence on how it goes. */
export function plainProgress(measure: ProgressMeasure | null): string {
  if (!measure || measure.points.length === 0) return t('mine.noResultYet');
  const { change } = measure;
  if (measure.points.length < 2) return t('mine.firstResult');
  if (change === null || change === undefined) return t('mine.tooFew');
  if (!measure.is_real_change) return t('mine.steady');
  const unit = displayUnit(measure.unit);
  const size = Math.abs(change * unit.factor);
  if (unit.suffix !== '°') return change > 0 ? t('mine.more') : t('mine.less');
  const degrees = number(size);
  const joint = tOr(`mine.joint.${/^range:(\w+)\./.exec(measure.measure)?.[1] ?? ''}`, t('mine.joint.other'));
  return change > 0 ? t('mine.further', { joint, degrees }) : t('mine.lessFar', { joint, degrees });
}
