import { describe, expect, it } from 'vitest';
import {
  age,
  bodyLength,
  bytes,
  day,
  difference,
  duration,
  number,
  position,
  quantity,
  span,
  pair,
  spreadAlone,
  uncertain,
} from '../../src/lib/format';

describe('numbers', () => {
  it('shows degrees only at the edge of the screen', () => {
    expect(quantity(Math.PI / 2, 'rad')).toBe('90°');
    expect(quantity(0.123, 'm')).toBe('12.3 cm');
    expect(quantity(1.234, 's')).toBe('1.2 s');
  });
  it('has a true minus sign and no negative zero', () => {
    expect(number(-5)).toBe('−5');
    expect(number(-0.04, 1)).toBe('0.0');
  });
  it('says nothing where there is nothing', () => {
    expect(quantity(null, 'rad')).toBe('–');
    expect(quantity(NaN, 'rad')).toBe('–');
    expect(uncertain(null, 1, 'rad')).toBe('–');
  });
  it('puts the uncertainty in the same unit', () => {
    expect(uncertain(Math.PI / 2, Math.PI / 60, 'rad')).toBe('90° ± 3');
    expect(uncertain(1.5, null, 's')).toBe('1.5 s');
    expect(uncertain(1.5, 0.02, 's')).toBe('1.50 s ± 0.02');
    expect(uncertain(8, 0, '%')).toBe('8 % ± 0');
  });
  it('gives a value the digits of its uncertainty, and nothing measured an uncertainty of nothing', () => {
    expect(uncertain(9.04, 0.43, 'deg')).toBe('9.0° ± 0.4');
    expect(uncertain(8, 0.4, '%')).toBe('8.0 % ± 0.4');
    expect(uncertain(8, 0.5, '%')).toBe('8 % ± 1');
    expect(uncertain(-0.9981, 0.0012, '1')).toBe('−0.998 ± 0.001');
    expect(uncertain(-0.99996, 0.00003, '1')).toBe('−1.000 ± < 0.001');
    expect(uncertain(9, 0.01, 'deg')).toBe('9.0° ± < 0.1');
    expect(pair(-12, -3, 0)).toEqual(['−12', '3']);
    expect(spreadAlone(0.04, 1)).toBe('0.04');
    expect(spreadAlone(0.004, 1)).toBe('< 0.01');
    expect(spreadAlone(-4, 1)).toBe('4.0');
  });
  it('keeps a unit it does not know', () => {
    expect(quantity(3, 'N')).toBe('3.00 N');
  });
  it('shows speeds of turning in degrees, however the service sends them', () => {
    expect(quantity(31.35, 'deg/s')).toBe('31 °/s');
    expect(quantity(Math.PI, 'rad/s')).toBe('180 °/s');
  });
  it('never shows a difference as nothing that is something', () => {
    expect(span(0.4, 'deg')).toBe('0.4°');
    expect(span(0.6, 'deg')).toBe('1°');
    expect(span(0, 'deg')).toBe('0°');
    expect(difference(-0.3, '%')).toBe('−0.3 percentage points');
  });
  it('writes sizes', () => {
    expect(bytes(480)).toBe('480 B');
    expect(bytes(2_500_000)).toBe('2.5 MB');
    expect(bytes(1_500_000_000)).toBe('1.50 GB');
  });
});

describe('times', () => {
  const now = new Date(2025, 4, 20, 15, 0);
  it('speaks as a person does', () => {
    expect(day(new Date(2025, 4, 20, 9, 5), now)).toBe('Today, 09:05');
    expect(day(new Date(2025, 4, 19, 23, 50), now)).toBe('Yesterday, 23:50');
    expect(day(new Date(2025, 4, 15, 9, 0), now)).toBe('5 days ago');
    expect(day(new Date(2024, 0, 3), now)).toBe('3 Jan 2024');
    expect(day(null, now)).toBe('Never');
  });
  it('counts years of age from the birthday', () => {
    expect(age('1960-05-20', now)).toBe(65);
    expect(age('1960-05-21', now)).toBe(64);
  });
  it('writes positions so that they carry over', () => {
    expect(position(65.25)).toBe('1:05.3');
    expect(position(59.97)).toBe('1:00.0');
    expect(position(5, 0)).toBe('0:05');
  });
  it('writes lengths in words', () => {
    expect(duration(45.2)).toBe('45 s');
    expect(duration(250)).toBe('4 min 10 s');
    expect(duration(240)).toBe('4 min');
  });
});

describe('lengths of the body', () => {
  it('has tenths only where they say something', () => {
    expect(bodyLength(1.66)).toBe('166 cm');
    expect(bodyLength(0.275)).toBe('27.5 cm');
    expect(bodyLength(null)).toBe('–');
  });
});
