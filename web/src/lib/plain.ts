// Results in plain words for the patient: a change is reported only when it is larger than what repeats by chance.
import type { MeasureValue, ProgressMeasure } from '../api/types';
import { t, tOr } from '../i18n';
import { displayUnit, number, quantity } from './format';

/** How far a joint moved; of a foot that walks other numbers say more. */
const isRange = (measure: string) => measure.startsWith('range:') && !measure.startsWith('range:foot_');

/** The measure a patient understands best: how far the main joint moved. */
export function mainMeasure(measures: readonly ProgressMeasure[]): ProgressMeasure | null {
  const withPoints = measures.filter((one) => one.points.length > 0);
  return withPoints.find((one) => isRange(one.measure)) ?? withPoints[0] ?? null;
}

/** The joint whose range a measure is, in a word everybody knows. */
export function jointOf(measure: string): string {
  return tOr(`mine.joint.${/^range:([a-z]+_[a-z]+)_(?:left|right)_/.exec(measure)?.[1] ?? ''}`, t('mine.joint.other'));
}

/** One sentence on how it goes: the newest session against the first three, as in the reports. */
export function plainProgress(measure: ProgressMeasure | null): string {
  if (!measure || measure.points.length === 0) return t('mine.noResultYet');
  const { change, is_real_change: isReal } = measure.points.at(-1) ?? {};
  if (measure.points.length < 2) return t('mine.firstResult');
  if (change === null || change === undefined) return t('mine.tooFew');
  if (!isReal) return t('mine.steady');
  const unit = displayUnit(measure.unit);
  const size = Math.abs(change * unit.factor);
  const way = change > 0 ? 'more' : 'less';
  if (measure.measure === 'walk:test_time')
    return t(`mine.walk.test_time.${way}`, { amount: quantity(Math.abs(change), measure.unit) });
  if (measure.measure === 'walk:test_distance')
    return t(`mine.walk.test_distance.${way}`, { amount: quantity(Math.abs(change), measure.unit) });
  if (measure.measure.startsWith('walk:speed')) return t(`mine.walk.speed.${way}`);
  if (unit.suffix !== '°') return t('mine.changed');
  const degrees = number(size);
  const joint = jointOf(measure.measure);
  return change > 0 ? t('mine.further', { joint, degrees }) : t('mine.lessFar', { joint, degrees });
}

/** What one session showed, in sentences that hold whatever was exercised: how often, how far, and how far the example went. */
export function plainFeedback(
  summary: readonly MeasureValue[],
  repetitions: number,
  primaryAngle: string | undefined,
): string[] {
  if (summary.some((one) => one.measure.startsWith('range:foot_'))) return [t('home.strides', { count: repetitions })];
  const ranges = summary.filter((one) => isRange(one.measure) && one.value !== null);
  const main = ranges.find((one) => one.measure === `range:${primaryAngle}`) ?? ranges[0];
  const said = [repetitions > 0 ? t('home.did', { count: repetitions }) : t('home.didNone')];
  const unit = displayUnit(main?.unit);
  if (main?.value === null || main?.value === undefined || repetitions === 0 || unit.suffix !== '°') return said;
  const degrees = number(main.value * unit.factor);
  const joint = jointOf(main.measure);
  said.push(
    main.template_value === null
      ? t('home.moved', { joint, degrees })
      : t('home.movedExample', { joint, degrees, example: number(main.template_value * unit.factor) }),
  );
  return said;
}

/** How often a movement was done in a session, by the progress of its exercise; null where that is not known. */
export function repetitionsOf(measures: readonly ProgressMeasure[], sessionId: string): number | null {
  const points = measures.filter((one) => isRange(one.measure)).flatMap((one) => one.points);
  return points.find((one) => one.session_id === sessionId)?.count ?? null;
}

/** What a measure is in the words of her own page. */
export function shortName(main: ProgressMeasure): string {
  return isRange(main.measure) ? t('mine.ownRange', { joint: jointOf(main.measure) }) : main.label;
}

/** Her own value of one session, e.g. `Your elbow: 59°`; empty where the session has none. */
export function plainValue(main: ProgressMeasure | null, sessionId: string): string {
  const point = main?.points.find((one) => one.session_id === sessionId);
  return main && point ? t('mine.ownValue', { name: shortName(main), value: quantity(point.value, main.unit) }) : '';
}
