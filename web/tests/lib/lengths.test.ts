import { expect, it } from 'vitest';
import { readLengthCm } from '../../src/lib/lengths';

it.each([
  ['1.68', 168],
  ['1,68', 168],
  ['1.68 m', 168],
  ['168', 168],
  ['168cm', 168],
  ['31.5', 31.5],
  ['0.31', 31],
  ['', null],
])('understands %j', (typed, cm) => expect(readLengthCm(typed)).toBe(cm));

it.each(['tall', '1.6.8', '5 ft', '-20'])('does not guess %j', (typed) => expect(readLengthCm(typed)).toBeNaN());
