// The design of a template as fields that can be changed apart from one another, and back.
import type { CueDesign, StopDesign, TemplateDesign, WeightDesign } from '../../api/types';
import { isSame, type Fields } from './merge';

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
function numbered<T>(rules: readonly T[], key: (one: T) => string): [string, T][] {
  const seen = new Map<string, number>();
  return rules.map((one) => {
    const name = key(one);
    const count = (seen.get(name) ?? 0) + 1;
    seen.set(name, count);
    return [count === 1 ? name : `${name}#${count}`, one];
  });
}

/** In how many of its parts a rule differs from another. */
function difference(one: object, other: object): number {
  const names = new Set([...Object.keys(one), ...Object.keys(other)]) as Set<never>;
  return [...names].filter((name) => !isSame(one[name], other[name])).length;
}

/**
 * Each rule by the name that it had in what was opened, also where others of its kind were added or deleted before it:
 * the same rule first, then the one that it is most like. A rule that is new has a name of its own.
 */
function byName<T extends object>(
  rules: readonly T[],
  opened: readonly T[],
  key: (one: T) => string,
  fresh: (one: T) => string = key,
): [string, T][] {
  const pairs = numbered(opened, key).flatMap(([name, before]) =>
    rules.flatMap((one, at) => (key(one) === key(before) ? [{ name, at, differs: difference(one, before) }] : [])),
  );
  const names = new Map<number, string>();
  const taken = new Set<string>();
  // Of equal ones, the first to the first.
  for (const { name, at } of pairs.sort((one, other) => one.differs - other.differs)) {
    if (names.has(at) || taken.has(name)) continue;
    names.set(at, name);
    taken.add(name);
  }
  const free = (wanted: string) => {
    let name = wanted;
    for (let count = 2; taken.has(name); count += 1) name = `${wanted}#${count}`;
    taken.add(name);
    return name;
  };
  return rules.map((one, at) => [names.get(at) ?? free(fresh(one)), one]);
}

/** Two new limits of one curve and side are two rules: both hold. Of the other kinds there is one. */
const newStopKey = (one: StopDesign) =>
  one.kind === 'limit' ? `${stopKey(one)}#=${one.limit?.toFixed(6)},${one.hold_s?.toFixed(6)}` : stopKey(one);

/** The limits and other rules that stop, as fields; `opened` are those that both people began from. */
export function stopFields(stops: readonly StopDesign[], opened: readonly StopDesign[]): Fields {
  return Object.fromEntries(byName(stops.map(stored), opened.map(stored), stopKey, newStopKey));
}

/** The rules that fields say. */
export function stopsOfFields(fields: Fields): StopDesign[] {
  return named(fields, 'stop:').map(([, one]) => one as StopDesign);
}

/** What a field is about, without its part and without which of several alike it is. */
export const subjectOf = (field: string) => field.slice(field.indexOf(':') + 1).replace(/#.*$/, '');

/** The fields of a design, by names that say which curve or rule they are of; `opened` is what both people began from. */
export function designFields(design: TemplateDesign, opened: TemplateDesign = design): Fields {
  return Object.fromEntries<unknown>([
    ['phases', design.phases ?? []],
    ...(design.tolerances ?? []).map((one) => [`band:${one.channel}`, one.knots] as const),
    ...(design.watched ?? []).map((channel) => [`watched:${channel}`, true] as const),
    ...Object.entries(stopFields(design.stops ?? [], opened.stops ?? [])),
    ...byName(design.cues ?? [], opened.cues ?? [], cueKey),
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
    stops: stopsOfFields(fields),
    cues: named(fields, 'cue:').map(([, one]) => one as CueDesign),
    valid_share: fields.valid_share as number,
    pace: { ...rest.pace, ...pace },
    weights: named(fields, 'weight:').map(([measure, weight]) => ({ measure, weight }) as WeightDesign),
  };
}
