// A typed catalogue: keys are checked, parameters are checked, plurals follow the language.
import { en } from './en';

type Entry = string | { readonly one: string; readonly other: string };
type Names<S extends string> = S extends `${string}{${infer Name}}${infer Rest}` ? Name | Names<Rest> : never;
type Parameters<E extends Entry> = E extends string
  ? { [K in Names<E>]: string | number }
  : { [K in Names<(E & { other: string })['other']> | 'count']: string | number };

export type Catalogue = {
  [K in keyof typeof en]: (typeof en)[K] extends string ? string : { one: string; other: string };
};
export type Key = keyof typeof en;
type Arguments<K extends Key> = keyof Parameters<(typeof en)[K]> extends never
  ? []
  : [values: Parameters<(typeof en)[K]>];

const catalogues: Record<string, Catalogue> = { en };
let language = 'en';
let catalogue: Catalogue = en;

/** Switch to the language of the signed-in person, if there is a catalogue for it. */
export function setLocale(locale: string): void {
  const wanted = locale.split('-')[0] ?? 'en';
  language = wanted in catalogues ? wanted : 'en';
  catalogue = catalogues[language] ?? en;
  if (typeof document !== 'undefined') document.documentElement.lang = language;
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
  return text.replace(/\{(\w+)\}/g, (_, name: string) => String(given[name] ?? `{${name}}`));
}

/** Whether there is a text for a key that is put together at run time, such as a code of the service. */
export function isKey(key: string): key is Key {
  return key in en;
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

/** A name as it stands within a sentence: without a capital of its own. */
export function withinSentence(name: string): string {
  return name.slice(0, 1).toLocaleLowerCase(formatLocale()) + name.slice(1);
}

/** The language for number and date formats; dates are written day first in English. */
export function formatLocale(): string {
  return language === 'en' ? 'en-GB' : language;
}
