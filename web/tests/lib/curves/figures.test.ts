import { expect, it } from 'vitest';
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
