import { expect, it } from 'vitest';
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
