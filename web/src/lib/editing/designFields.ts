// The design of a template as fields that can be changed apart from one another, and back.
import type { CueDesign, StopDesign, TemplateDesign, WeightDesign } from '../../api/types';
import type { Fields } from './merge';

/** As the service stores it, with what it adds where the page leaves it out: two ways to write one rule are one field. */
function stored(one: StopDesign): StopDesign {
  const { kind, limit = 0, hold_s = 0.05 } = one;
  return kind === 'limit'
    ? { kind, channel: one.channel ?? '', side: one.side ?? 'above', limit, hold_s }
    : { kind, limit, hold_s };
}

const stopKey = ({ kind, channel, side }: StopDesign) => `stop:${kind}|${channel ?? ''}|${side ?? ''}`;
const cueKey = (one: CueDesign) =>
  `cue:${one.quantity}|${one.sentence}|${one.channel ?? ''}|${one.side ?? 'both'}|${(one.phases ?? [0, 1]).join('-')}`;

/** Each rule by its name; the second of the same name is another field. */
function byName<T>(rules: readonly T[], key: (one: T) => string): [string, T][] {
  const seen = new Map<string, number>();
  return rules.map((one) => {
    const name = key(one);
    const count = (seen.get(name) ?? 0) + 1;
    seen.set(name, count);
    return [count === 1 ? name : `${name}#${count}`, one];
  });
}

/** The fields of a design, by names that say which curve or rule they are of. */
export function designFields(design: TemplateDesign): Fields {
  return Object.fromEntries<unknown>([
    ['phases', design.phases ?? []],
    ...(design.tolerances ?? []).map((one) => [`band:${one.channel}`, one.knots] as const),
    ...(design.watched ?? []).map((channel) => [`watched:${channel}`, true] as const),
    ...byName((design.stops ?? []).map(stored), stopKey),
    ...byName(design.cues ?? [], cueKey),
    ['valid_share', design.valid_share],
    ['pace:silence_s', design.pace?.silence_s],
    ['pace:praise_every', design.pace?.praise_every],
    ['pace:cue_every', design.pace?.cue_every],
    ...(design.weights ?? []).map((one) => [`weight:${one.measure}`, one.weight] as const),
  ]);
}

const named = (fields: Fields, part: string) =>
  Object.entries(fields)
    .filter(([name, value]) => name.startsWith(part) && value !== undefined)
    .map(([name, value]) => [name.slice(part.length), value] as const);

/** The design that fields say; `rest` gives what is no field. */
export function designOfFields(fields: Fields, rest: TemplateDesign): TemplateDesign {
  const pace = Object.fromEntries(named(fields, 'pace:'));
  return {
    ...rest,
    phases: fields.phases as TemplateDesign['phases'],
    tolerances: named(fields, 'band:').map(([channel, knots]) => ({ channel, knots: knots as never })),
    watched: named(fields, 'watched:').map(([channel]) => channel),
    stops: named(fields, 'stop:').map(([, one]) => one as StopDesign),
    cues: named(fields, 'cue:').map(([, one]) => one as CueDesign),
    valid_share: fields.valid_share as number,
    pace: { ...rest.pace, ...pace },
    weights: named(fields, 'weight:').map(([measure, weight]) => ({ measure, weight }) as WeightDesign),
  };
}
