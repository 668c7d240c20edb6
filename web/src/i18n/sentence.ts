// Sentences of the service in the language of the reader: code and parameters from the service, words from the files in `messages`,
// which the service reads too. Places are written as by `estimators/sentences/_formats.py`. The service itself writes
// English: no page loads the English file to read what it was sent, only those that know a code and no text (`codes.ts`).
import { currentLanguage, formatLocale, withinSentence } from './index';
import { relabel } from './labels';
import { parsed, type Message, type Place } from './message';

/** What a text of the service says, for saying it again. */
export interface Sentence {
  code: string;
  params?: Record<string, unknown>;
}

/** Messages by code. */
export type Sentences = Record<string, string | undefined>;

const catalogues: Record<string, Sentences> = {};

/** From now on sentences in this language are said with these words. */
export function speak(language: string, sentences: Sentences): void {
  catalogues[language] = sentences;
}

/** Whether sentences in this language are said with words of its own. */
export function isSpoken(language: string): boolean {
  return language in catalogues;
}

const UNITS: Record<string, { factor: number; suffix: string; digits: number } | undefined> = {
  s: { factor: 1, suffix: ' s', digits: 0 },
  ms: { factor: 1e3, suffix: ' ms', digits: 0 },
  min: { factor: 1 / 60, suffix: ' min', digits: 0 },
  hz: { factor: 1, suffix: ' Hz', digits: 0 },
  m: { factor: 1, suffix: ' m', digits: 1 },
  cm: { factor: 1e2, suffix: ' cm', digits: 0 },
  mm: { factor: 1e3, suffix: ' mm', digits: 0 },
  deg: { factor: 180 / Math.PI, suffix: '°', digits: 0 },
  degps: { factor: 180 / Math.PI, suffix: ' °/s', digits: 0 },
  mps: { factor: 1, suffix: ' m/s', digits: 2 },
  mps2: { factor: 1, suffix: ' m/s²', digits: 1 },
  ut: { factor: 1e6, suffix: ' µT', digits: 0 },
  percent: { factor: 1e2, suffix: ' %', digits: 0 },
  points: { factor: 1e2, suffix: '', digits: 0 },
  mib: { factor: 2 ** -20, suffix: ' MiB', digits: 0 },
  gib: { factor: 2 ** -30, suffix: ' GiB', digits: 0 },
  kib: { factor: 2 ** -10, suffix: ' KiB', digits: 0 },
  kg: { factor: 1, suffix: ' kg', digits: 0 },
};
const NUMBER = { factor: 1, suffix: '', digits: 0 };

const isSentence = (value: unknown): value is Sentence =>
  typeof value === 'object' && value !== null && 'code' in value;
const all = (value: unknown): unknown[] => (Array.isArray(value) ? value : [value]);

function listed(words: readonly string[], last = ''): string {
  return new Intl.ListFormat(formatLocale(), { type: last === 'or' ? 'disjunction' : 'conjunction' }).format(words);
}

function quantity(value: unknown, style: string): string {
  const found = /^(?<name>\w*)(?:\.(?<digits>\d+)|~(?<significant>\d+))?$/.exec(style)?.groups;
  const unit = UNITS[found?.name ?? ''] ?? NUMBER;
  const digits = found?.digits === undefined ? unit.digits : Number(found.digits);
  const length =
    found?.significant === undefined
      ? { minimumFractionDigits: digits, maximumFractionDigits: digits }
      : { maximumSignificantDigits: Number(found.significant) };
  const text = new Intl.NumberFormat(formatLocale(), { ...length, useGrouping: false }).format(
    Number(value) * unit.factor,
  );
  return text.replace('-', /[1-9]/.test(text) ? '−' : '') + unit.suffix;
}

function written(value: unknown, { kind, style }: Place, words: Sentences): string {
  const plain = (one: unknown) => (isSentence(one) ? (said(one, words) ?? '') : String(one));
  // Within a sentence a sentence has no capital of its own.
  const within = (one: unknown) => (isSentence(one) ? withinSentence(plain(one)) : plain(one));
  if (!kind) return plain(value);
  if (kind === 'number') return quantity(value, style);
  if (kind === 'list')
    return style === 'lines' ? all(value).map(plain).join(' ') : listed(all(value).map(within), style);
  const [register = '', last] = style.split(' ');
  const names = all(value).map((one) => {
    const entry = words[`${register}.${String(one)}`];
    return entry === undefined ? String(one) : put(parsed(entry), {}, words);
  });
  return listed(names, last);
}

/** The text of a message with its places filled. */
function put(message: Message, params: Record<string, unknown>, words: Sentences): string {
  const texts = message.map((part) => {
    if (typeof part === 'string') return part;
    const value = params[part.name] ?? '';
    if (!('branches' in part)) return written(value, part, words);
    const { branches } = part;
    const category = new Intl.PluralRules(currentLanguage()).select(Number(value));
    return put(branches[category] ?? branches.other ?? [], params, words);
  });
  return texts.join('');
}

/** A sentence in the words of a catalogue; null where the catalogue does not have it. */
export function said(sentence: Sentence, words: Sentences): string | null {
  const entry = words[sentence.code];
  if (entry === undefined) return null;
  const text = put(parsed(entry), sentence.params ?? {}, words);
  return text.slice(0, 1).toLocaleUpperCase(formatLocale()) + text.slice(1);
}

/** The service's text in the reader's language; as the service wrote it where nothing is known of it. */
export function words(text: string, sentence: Sentence | null | undefined): string {
  if (!sentence) return text;
  return said(sentence, catalogues[currentLanguage()] ?? {}) ?? text;
}

const isObject = (value: unknown): value is Record<string, unknown> =>
  typeof value === 'object' && value !== null && !Array.isArray(value);

function spoken(text: unknown, sentence: unknown): unknown {
  if (Array.isArray(text) && Array.isArray(sentence)) return text.map((one, at) => spoken(one, sentence[at]));
  return typeof text === 'string' && isSentence(sentence) ? words(text, sentence) : text;
}

/** An answer of the service with every text in the reader's language, in place: each object names the sentences of its own texts. */
export function inOurWords<T>(answer: T): T {
  if (Array.isArray(answer)) {
    // Curves are long and hold no words.
    if (typeof answer[0] !== 'number') answer.forEach(inOurWords);
  } else if (isObject(answer)) {
    if (isObject(answer.sentences)) {
      const fields: Record<string, unknown> = answer;
      for (const [name, sentence] of Object.entries(answer.sentences)) fields[name] = spoken(fields[name], sentence);
    }
    const own = catalogues[currentLanguage()];
    if (own) relabel(answer, (code) => (code in own ? said({ code }, own) : null));
    for (const [name, value] of Object.entries(answer))
      if (name !== 'sentences' && typeof value === 'object') inOurWords(value);
  }
  return answer;
}
