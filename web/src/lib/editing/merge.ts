// Two people changed the same thing: what each changed is joined field by field, and only a field that both changed is asked.

/** Values by the name of their field; a field that is absent has none. */
export type Fields = Readonly<Record<string, unknown>>;
export type Side = 'mine' | 'theirs';

/** A field that differs between what was opened and what is stored now. */
export interface FieldChange {
  field: string;
  before: unknown;
  theirs: unknown;
}
/** A field that both changed, to different values. */
export interface Fork extends FieldChange {
  mine: unknown;
}
export interface Merge {
  /** What the other person changed and what stands where nobody else changed it. */
  theirs: FieldChange[];
  forks: Fork[];
  /** What I deleted and the other person left as it was. */
  mineRemoved: { field: string; before: unknown }[];
  /** All fields, with the choice made for each fork; the stored value where none was made. */
  merged: (choices: Readonly<Record<string, Side | undefined>>) => Fields;
}

/** The same value is the same text, whatever the order of keys; what is null or empty text is not there, as in answers of the service. */
function canonical(value: unknown): unknown {
  if (Array.isArray(value)) return value.map(canonical);
  if (typeof value === 'number') return Number(value.toFixed(6));
  if (typeof value !== 'object' || value === null) return value ?? null;
  return Object.fromEntries(
    Object.entries(value)
      .filter(([, one]) => one !== null && one !== undefined && one !== '')
      .sort(([one], [other]) => (one < other ? -1 : 1))
      .map(([name, one]) => [name, canonical(one)]),
  );
}

/** Whether two values say the same. */
export function isSame(one: unknown, other: unknown): boolean {
  return JSON.stringify(canonical(one)) === JSON.stringify(canonical(other));
}

/** Join two changes of the same state: `before` was opened by both, `theirs` is stored now, `mine` is not saved yet. */
export function merge(before: Fields, mine: Fields, theirs: Fields): Merge {
  // In the order of what is stored: in a list of cues the uppermost comes first.
  const names = [...new Set([...Object.keys(theirs), ...Object.keys(mine), ...Object.keys(before)])];
  const isMine = (name: string) => !isSame(mine[name], before[name]);
  const changed = names
    .filter((name) => !isSame(theirs[name], before[name]))
    .map((field) => ({ field, before: before[field], theirs: theirs[field], mine: mine[field] }));
  const forks = changed.filter((one) => isMine(one.field) && !isSame(one.mine, one.theirs));
  const isFork = new Set(forks.map((one) => one.field));
  return {
    theirs: changed.filter((one) => !isFork.has(one.field)),
    forks,
    mineRemoved: names
      .filter((name) => isMine(name) && isSame(mine[name], undefined) && isSame(theirs[name], before[name]))
      .map((field) => ({ field, before: before[field] })),
    merged: (choices) =>
      Object.fromEntries(
        names.map((name) => {
          const takesMine = isFork.has(name) ? choices[name] === 'mine' : isMine(name);
          return [name, takesMine ? mine[name] : theirs[name]];
        }),
      ),
  };
}
