// Results in plain words for the patient: a change is said only where it is sure, and nothing where little is known.
import type { MeasureValue, ProgressMeasure } from '../api/types';
import { t, tOr } from '../i18n';
import { isSure, shownChange } from './assessment/trend';
import { displayUnit, number, quantity } from './format';

/** How far a joint moved; of a foot that walks other numbers say more. */
const isRange = (measure: string) => measure.startsWith('range:') && !measure.startsWith('range:foot_');

/** The measure a patient understands best: how far the main joint moved. */
export function mainMeasure(measures: readonly ProgressMeasure[]): ProgressMeasure | null {
  const withPoints = measures.filter((one) => one.points.length > 0);
  return withPoints.find((one) => isRange(one.measure)) ?? withPoints[0] ?? null;
}

const isElbow = (measure: string) => measure.startsWith('range:humerus_forearm');

/** The joint whose range a measure is, in a word everybody knows. */
export function jointOf(measure: string): string {
  return tOr(`mine.joint.${/^range:([a-z]+_[a-z]+)_(?:left|right)_/.exec(measure)?.[1] ?? ''}`, t('mine.joint.other'));
}

/** Since when, in words: the beginning, or the eight weeks that a trend looks back. */
function sinceWhen(measure: ProgressMeasure): string {
  // The baseline is the mean moment of its day.
  const day = (at: string) => new Date(at).toDateString();
  const first = measure.points[0]?.at ?? measure.trend.since;
  return t(day(first) === day(measure.trend.since) ? 'mine.beginning' : 'mine.eightWeeks');
}

/** One sentence on how it goes, where one may be said; null where nothing is known. */
export function plainProgress(measure: ProgressMeasure | null): string | null {
  if (!measure || measure.points.length === 0) return t('mine.noResultYet');
  const { trend } = measure;
  const when = sinceWhen(measure);
  switch (trend.word) {
    case 'values':
    case 'unknown':
    case 'probably_less':
      return null;
    case 'probably_more':
      return t('mine.looksLikeMore');
    case 'unchanged':
      return t('mine.asBefore', { when });
    case 'a_little_more':
      return t('mine.aLittleMore', { when });
    case 'a_little_less':
      return t('mine.aLittleLess', { when });
    default:
      return isSure(measure) ? changed(measure, when) : t('mine.asBefore', { when });
  }
}

/** A change that is sure, in the words of what is measured. */
function changed(measure: ProgressMeasure, when: string): string {
  const { trend } = measure;
  const change = shownChange(trend, measure.unit)?.change ?? 0;
  const unit = displayUnit(measure.unit);
  const way = trend.word === 'more' ? 'more' : 'less';
  const amount = quantity(Math.abs(change), measure.unit);
  if (measure.measure === 'walk:test_time') return t(`mine.walk.test_time.${way}`, { amount, when });
  if (measure.measure === 'walk:test_distance') return t(`mine.walk.test_distance.${way}`, { amount, when });
  if (measure.measure.startsWith('walk:speed')) return t(`mine.walk.speed.${way}`, { when });
  if (unit.suffix !== '°') return t('mine.changed', { when });
  const degrees = number(Math.abs(change * unit.factor));
  if (isElbow(measure.measure)) return t(`mine.elbow.${way}`, { degrees, when });
  const joint = jointOf(measure.measure);
  return way === 'more' ? t('mine.further', { joint, degrees, when }) : t('mine.lessFar', { joint, degrees, when });
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
