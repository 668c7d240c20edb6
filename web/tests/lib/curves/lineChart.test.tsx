// Lines of different times on common axes.
import { render } from '@testing-library/react';
import { expect, it } from 'vitest';
import { LineChart } from '../../../src/charts/LineChart';

const LINES = [
  { name: 'a', x: [1, 10], y: [1, 3] },
  { name: 'b', x: [1, null, 5, 10], y: [5, 9, null, 0] },
];

const paths = (isLogarithmic: boolean) => {
  const props = { xTitle: 'Time', yTitle: 'Error', label: 'Errors', logarithmic: isLogarithmic };
  const { container } = render(<LineChart lines={LINES} {...props} />);
  return [...container.querySelectorAll('.chart > path')].map((one) => one.getAttribute('d') ?? '');
};

it('draws each line at its own times, with holes where it has no number', () => {
  const [whole, holed] = paths(false);
  expect(whole).toMatch(/^M88,[\d.]+L790,[\d.]+$/);
  expect(holed).toBe('M88,116ZM790,222Z');
});

it('has no place for zero on logarithmic axes', () => {
  expect(paths(true)[1]).toMatch(/^M88,[\d.]+Z$/);
});
