// A typed catalogue: keys are checked, parameters are checked, plurals follow the language. Every language comes in a piece of
// its own (`languages.ts`); here is which one is spoken.
import type { words as english } from './en';

type Entry = string | { readonly one: string; readonly other: string };
type Names<S extends string> = S extends `${string}{${infer Name}}${infer Rest}` ? Name | Names<Rest> : never;
type Parameters<E extends Entry> = E extends string
  ? { [K in Names<E>]: string | number }
  : { [K in Names<(E & { other: string })['other']> | 'count']: string | number };

/** The words of one file in another language: the same keys, plurals where English has them. */
export type Translated<English> = { readonly [K in keyof English]: English[K] extends string ? string : Plural };
interface Plural {
  readonly one: string;
  readonly other: string;
}
export type Catalogue = Translated<typeof english>;
export type Key = keyof Catalogue;
type Arguments<K extends Key> = keyof Parameters<(typeof english)[K]> extends never
  ? []
  : [values: Parameters<(typeof english)[K]>];

let language = 'en';
// Nothing is drawn before the first language has come.
let catalogue = {} as Catalogue;

/** From now on this language is spoken with these words. */
export function speakWith(name: string, words: Catalogue): void {
  language = name;
  catalogue = words;
  if (typeof document !== 'undefined') document.documentElement.lang = name;
}

/** A text with its places filled. A value that ends with a point, as German short dates do, ends the sentence too. */
function put(text: string, value: (name: string) => string): string {
  return text.replace(/\{(\w+)\}(\.(?!\.))?/g, (_, name: string, point = '') => {
    const filled = value(name);
    return filled.endsWith('.') ? filled : filled + String(point);
  });
}

/** The text of a key with its parameters put in. */
export function t<K extends Key>(key: K, ...values: Arguments<K>): string {
  const entry: Entry = catalogue[key];
  const given = (values[0] ?? {}) as Record<string, string | number>;
  const text =
    typeof entry === 'string'
      ? entry
      : new Intl.PluralRules(language).select(Number(given.count)) === 'one'
        ? entry.one
        : entry.other;
  return put(text, (name) => String(given[name] ?? `{${name}}`));
}

/** Whether there is a text for a key that is put together at run time, such as a code of the service. */
export function isKey(key: string): key is Key {
  return key in catalogue;
}

/** The text of a key without parameters that is put together at run time, or the fallback. */
export function tOr(key: string, fallback: string): string {
  if (!isKey(key)) return fallback;
  const entry: Entry = catalogue[key];
  return typeof entry === 'string' ? entry : fallback;
}

/** The language that is spoken at present. */
export function currentLanguage(): string {
  return language;
}

/** A name as it stands within a sentence: without a capital of its own, except in German, where nouns keep theirs. */
export function withinSentence(name: string): string {
  return language === 'de' ? name : name.slice(0, 1).toLocaleLowerCase(formatLocale()) + name.slice(1);
}

/** The language for number and date formats; dates are written day first in English. */
export function formatLocale(): string {
  return language === 'en' ? 'en-GB' : language;
}
