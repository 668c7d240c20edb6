// What measures, curves, estimators and file formats are called. The service labels them in English; in another language the labels
// are made anew of their names.
import { t, tOr } from './index';

const ANGLE = /^([a-z]+_[a-z]+)_(?:left|right)_[a-z]{3}_([a-z_]+)$/;
const POINT = /^([a-z]+)(?:_(?:left|right))?\.([xyz])$/;
const SCALAR = /^(.*?)(?:_(?:left|right))?_(?:rad|m|mps)$/;

/** A curve without its side, as the service labels it; null where nothing is known of it. */
function curve(channel: string): string | null {
  const [, joint, movement] = ANGLE.exec(channel) ?? [];
  if (joint && movement) return tOr(`angle.${joint}.${movement}`, '') || null;
  const [, place, axis] = POINT.exec(channel) ?? [];
  if (place && axis) {
    const name = tOr(`point.${place}`, '');
    return name ? `${name}, ${tOr(`axis.${axis}`, axis)}` : null;
  }
  return tOr(`scalar.${SCALAR.exec(channel)?.[1] ?? channel}`, '') || null;
}

/** The label of a measure or of a curve, with names of measures by their code; null where nothing is known of it. */
function labelOf(
  about: { measure?: unknown; channel?: unknown },
  named: (code: string) => string | null,
): string | null {
  if (typeof about.channel === 'string') return curve(about.channel);
  if (typeof about.measure !== 'string') return null;
  const [first = '', second = '', third = ''] = about.measure.split(':');
  if (first !== 'walk') {
    const name = named(`measure_name.repetition.${first}`);
    const channel = second ? curve(second) : '';
    return name === null || channel === null ? null : channel ? `${channel}, ${name}` : name;
  }
  if (second === 'uneven') return named(`measure_name.uneven.${third}`);
  const name = named(`measure_name.walk.${second}`);
  // Both feet walk at one speed: the service names it once, under one of them.
  if (second === 'speed') return name;
  return name !== null && (third === 'left' || third === 'right') ? `${name}, ${t(`side.${third}`)}` : name;
}

type Named = Record<string, unknown>;

/** Labels, titles and descriptions of one object of an answer, in place. */
export function relabel(answer: Named, named: (code: string) => string | null): void {
  if (typeof answer.label === 'string') answer.label = labelOf(answer, named) ?? answer.label;
  if (typeof answer.main_measure === 'string')
    answer.main_measure = labelOf({ measure: answer.main_measure_name }, named) ?? answer.main_measure;
  const register = 'is_offline' in answer ? 'estimator' : 'endings' in answer ? 'format' : null;
  if (register && typeof answer.name === 'string') {
    answer.title = named(`${register}_title.${answer.name}`) ?? answer.title;
    answer.description = named(`${register}_text.${answer.name}`) ?? answer.description;
  }
}
