import { expect, it } from 'vitest';
import { aligned } from '../../../src/charts/scales';
import { figure, unitSign } from '../../../src/lib/assessment/figures';

it('shows measured numbers with the digits that count', () => {
  expect(figure(2.43, 'deg')).toBe('2.43°');
  expect(figure(0.7242097, 'deg')).toBe('0.724°');
  expect(figure(99.2, '%')).toBe('99.2 %');
  expect(figure(100, '%')).toBe('100 %');
  expect(figure(10000, '')).toBe('10,000');
  expect(figure(2, 'deg')).toBe('2°');
  expect(figure(0, '1')).toBe('0');
  expect(figure(6.66e-16, '1')).toBe('6.7 · 10⁻¹⁶');
  expect(figure(null, 'deg')).toBe('–');
  expect(unitSign('cm')).toBe(' cm');
});

it('lays lines of different times over one axis', () => {
  const data = aligned([
    { name: 'a', x: [0, 2], y: [1, 3] },
    { name: 'b', x: [1, null, 2], y: [5, 9, null] },
  ]);
  expect(data[0]).toEqual([0, 1, 2]);
  // A hole is null; where the other line has no point there is nothing, which is drawn through.
  expect(data[1]).toEqual([1, undefined, 3]);
  expect(data[2]).toEqual([undefined, 5, null]);
});
