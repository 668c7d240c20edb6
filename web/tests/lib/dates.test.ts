import { speakWith } from '../../src/i18n';
import { words as german } from '../../src/i18n/de';
import { words as english } from '../../src/i18n/en';
import { afterEach, describe, expect, it } from 'vitest';
import { dayWords, readDay } from '../../src/lib/dates';

it.each([
  ['3 Mar 1961', '1961-03-03'],
  ['03/04/1961', '1961-04-03'],
  ['3.4.1961', '1961-04-03'],
  ['1961-04-03', '1961-04-03'],
  ['29 February 2024', '2024-02-29'],
  ['', ''],
  ['31 Feb 2024', null],
  ['13/13/2020', null],
  ['soon', null],
])('reads %j day first', (typed, day) => expect(readDay(typed)).toBe(day));

it('shows what it understood, so that day and month cannot be mixed up', () => {
  expect(dayWords('1961-04-03')).toBe('3 Apr 1961');
  expect(readDay(dayWords('1961-04-03'))).toBe('1961-04-03');
});

describe('a day in German', () => {
  afterEach(() => speakWith('en', english));

  it('is read by the names of German months and written in figures', () => {
    speakWith('de', german);
    expect(readDay('31. März 2025')).toBe('2025-03-31');
    expect(readDay('5. Dez. 2025')).toBe('2025-12-05');
    expect(dayWords('2025-03-31')).toBe('31.03.2025');
    expect(readDay(dayWords('2025-03-31'))).toBe('2025-03-31');
  });
});
