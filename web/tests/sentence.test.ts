// Sentences of the service are said by the client with the same words and formats as by the service.
import { afterEach, describe, expect, it } from 'vitest';
import formats from '../../tests/data/sentence_formats.json';
import english from '../../messages/en.json';
import { wordsOf } from '../src/i18n/codes';
import { parsed, type Message } from '../src/i18n/message';
import { inOurWords, said, speak, words, type Sentences } from '../src/i18n/sentence';

const catalogue: Sentences = english;
const names = (message: Message): string[] =>
  message.flatMap((part) => {
    if (typeof part === 'string') return [];
    const inner = 'branches' in part ? Object.values(part.branches).flatMap((branch) => names(branch ?? [])) : [];
    return [part.name, ...inner];
  });
afterEach(() => speak('en', {}));

describe('sentences of the service', () => {
  it.each(formats as [string, unknown, string][])('writes %s with %j as %s', (entry, x, expected) => {
    expect(said({ code: 'test', params: { x } }, { ...catalogue, test: entry })).toBe(expected);
  });

  it('shows the words of the service where it knows none of its own', () => {
    expect(words('An old row.', null)).toBe('An old row.');
    expect(words('Of a newer service.', { code: 'no.such', params: {} })).toBe('Of a newer service.');
  });

  it('puts its own words into answers, however deep', () => {
    speak('en', catalogue);
    const sentence = { code: 'side.left', params: {}, text: 'LEFT' };
    const answer = inOurWords({
      rows: [{ text: 'LEFT', note: 'kept', sentences: { text: sentence } }],
      reasons: ['LEFT', 'plain'],
      sentences: { reasons: [sentence, 'plain'] },
    });
    expect(answer.rows[0]).toMatchObject({ text: 'Left', note: 'kept' });
    expect(answer.reasons).toEqual(['Left', 'plain']);
  });

  it('leaves answers in the words of the service while it was given none of its own', () => {
    const sentence = { code: 'side.left', params: {}, text: 'LEFT' };
    expect(inOurWords({ text: 'LEFT', sentences: { text: sentence } }).text).toBe('LEFT');
    expect(wordsOf('side.left')).toBe('Left');
    expect(wordsOf('no.such')).toBe('no.such');
  });

  it.each(Object.entries(english))('renders %s', (code, entry) => {
    const params = Object.fromEntries(names(parsed(entry)).map((name) => [name, 2]));
    const text = said({ code, params }, catalogue);
    expect(text).toBeTruthy();
    expect(text).not.toMatch(/[{}]|''|undefined|NaN|\s\s/);
  });
});
