// German says everything that English says, with the same places, and nothing of it is English.
import { afterEach, describe, expect, it } from 'vitest';
import germanMessages from '../../../messages/de.json';
import englishMessages from '../../../messages/en.json';
import { speakWith, t, withinSentence } from '../../src/i18n';
import { words as german } from '../../src/i18n/de';
import { words as english } from '../../src/i18n/en';
import { parsed, type Message } from '../../src/i18n/message';
import { said } from '../../src/i18n/sentence';

type Entry = string | { one: string; other: string };
type Words = Record<string, Entry>;
/** A message as the words of the pages are written; of a place its kind and style stand behind its name. */
const shown = (message: Message): string =>
  message
    .map((part) => {
      if (typeof part === 'string') return part;
      if ('branches' in part)
        return Object.values(part.branches)
          .map((branch) => shown(branch ?? []))
          .join(' ');
      return part.kind ? `{${part.name}:${part.kind} ${part.style}}` : `{${part.name}}`;
    })
    .join('');
function entryOf(text: string): Entry {
  const message = parsed(text);
  const [first] = message;
  if (message.length > 1 || typeof first !== 'object' || !('branches' in first)) return shown(message);
  const { one = [], other = [] } = first.branches;
  return { one: shown(one), other: shown(other) };
}
const entriesOf = (messages: Record<string, string>): Words =>
  Object.fromEntries(Object.entries(messages).map(([code, text]) => [code, entryOf(text)]));
const PAIRS: [string, Words, Words][] = [
  ['words of the pages', english, german],
  ['sentences of the service', entriesOf(englishMessages), entriesOf(germanMessages)],
];
/** In English the service has them where the things are; tests/structure/test_sentences.py compares them. */
const TITLES = /^(?:(?:estimator|format)_(?:title|text)|measure_name\.\w+)\./;
/** What is the same in both languages: names, units, and words that German took over. */
const ALIKE = new Set([
  'Arm',
  'Band',
  'Hand',
  'In',
  'Marker',
  'Name',
  'Pause',
  'Phase {number}',
  'Sensor',
  'Sensor: {place}.',
  'Signal {number}',
  'Telemotion',
  'Telemotion {version}',
  'Ticket',
  'Version',
  'Version {number}, {date}',
  'cm',
  'mm',
  '{minutes} min {seconds} s',
  '{minutes} min',
  '{title}, live',
  '{quantity:code quantity} in {unit:code unit} ({columns})',
  '± (mm)',
]);
/** English words that no German sentence has; `an`, `in`, `was`, `am`, `also`, `war`, `die` are German too. */
const STOP =
  /\b(the|and|of|with|your|you|is|are|this|that|to|for|from|not|no|by|on|it|or|be|has|have|one|when|which|than|only|sensor's|patient's)\b/i;

const texts = (entry: Entry): string[] => (typeof entry === 'string' ? [entry] : Object.values(entry));
const places = (text: string): string[] => [...new Set(text.match(/\{\w+(?::[^}]*)?\}/g) ?? [])].sort();
/** Without places, what is written as code, and signs. */
const plain = (text: string) => text.replace(/\{[^}]*\}|`[^`]*`|„telemotion [^“]*“|\bfor\b(?=m-data)/g, ' ');

afterEach(() => speakWith('en', english));

describe.each(PAIRS)('the %s', (_, ours, theirs) => {
  it('have the same keys', () => {
    const keys = Object.keys(theirs).filter((key) => !TITLES.test(key));
    expect(keys.sort()).toEqual(Object.keys(ours).sort());
  });

  it('have the same places, plurals where English has them', () => {
    for (const [key, entry] of Object.entries(ours)) {
      const other = theirs[key] as Entry;
      expect(typeof other, key).toBe(typeof entry);
      if (typeof entry === 'string' || typeof other === 'string')
        expect(places(texts(other).join(' ')), key).toEqual(places(texts(entry).join(' ')));
      else {
        expect(places(other.other), key).toEqual(places(entry.other));
        expect(places(entry.other), key).toEqual(expect.arrayContaining(places(other.one)));
      }
    }
  });

  it('are not left in English', () => {
    const same = Object.entries(ours)
      .flatMap(([key, entry]) => texts(entry).map((text, at) => [key, text, texts(theirs[key] as Entry)[at]] as const))
      .filter(([, text, other]) => text === other && /[a-z]{2}/i.test(plain(text)) && !ALIKE.has(text));
    expect(same.map(([key, text]) => `${key}: ${text}`)).toEqual([]);
  });

  it('have no English word left in them', () => {
    const found = Object.entries(theirs)
      .flatMap(([key, entry]) => texts(entry).map((text) => [key, text] as const))
      .filter(([, text]) => STOP.test(plain(text)));
    expect(found.map(([key, text]) => `${key}: ${text}`)).toEqual([]);
  });

  it('let no line end between a number and what hangs on it', () => {
    const broken = Object.entries(theirs).filter(([, entry]) => texts(entry).some((text) => /\}-\p{Ll}/u.test(text)));
    expect(broken.map(([key]) => key)).toEqual([]);
  });
});

describe('German', () => {
  it('is spoken with its own plurals, numbers, lists and capitals', () => {
    speakWith('de', german);
    expect(document.documentElement.lang).toBe('de');
    expect(t('time.daysAgo', { count: 1 })).toBe('vor 1 Tag');
    expect(t('time.daysAgo', { count: 3 })).toBe('vor 3 Tagen');
    expect(withinSentence('Oberarm links')).toBe('Oberarm links');
    const body = { code: 'body.stature', params: { stature_m: 170 } };
    expect(said(body, germanMessages)).toContain('170,00 m');
    const lost = { code: 'live.sends_nothing', params: { sensors: ['head', 'hand_left'] } };
    expect(said(lost, germanMessages)).toContain('Kopf und Hand links');
  });
});

it('has each key in one file only: the later of two would silently replace the words of the earlier', () => {
  const files = import.meta.glob<Record<string, Words>>(
    ['../../src/i18n/en/**/*.ts', '!../../src/i18n/en/index.ts', '../../src/kinds/*/words/en.ts'],
    { eager: true },
  );
  const where = new Map<string, string[]>();
  for (const [file, pieces] of Object.entries(files))
    for (const piece of Object.values(pieces))
      for (const key of Object.keys(piece)) where.set(key, [...(where.get(key) ?? []), file]);
  expect(where.size).toBeGreaterThan(1000);
  expect([...where].filter(([, found]) => found.length > 1)).toEqual([]);
});

it.each(PAIRS)('calls it a sensor box in the %s, not a gateway', (_, ...both) => {
  // These are read by who writes or runs a gateway.
  const forPrograms = /^(hello|scaled)\.|^sign_in\.device_token_only$/;
  const found = both.flatMap((words) =>
    Object.entries(words)
      .filter(([key]) => !forPrograms.test(key))
      .flatMap(([key, entry]) => (/gateway/i.test(texts(entry).join(' ')) ? [key] : [])),
  );
  expect(found).toEqual([]);
});
