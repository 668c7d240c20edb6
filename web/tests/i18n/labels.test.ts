// Labels in the reader's language: with the side where it tells two numbers apart, without it where there is one.
import { expect, it } from 'vitest';
import { relabel } from '../../src/i18n/labels';

const label = (measure: string) => {
  const answer: Record<string, unknown> = { measure, label: 'as the service says it' };
  relabel(answer, (code) => `<${code}>`);
  return answer.label;
};

it('names the speed of a walk once, for both feet', () => {
  expect(label('walk:speed:left')).toBe('<measure_name.walk.speed>');
  const row: Record<string, unknown> = { main_measure: 'Walking speed', main_measure_name: 'walk:speed:left' };
  relabel(row, (code) => `<${code}>`);
  expect(row.main_measure).toBe('<measure_name.walk.speed>');
});

it('says the side of what each foot has of its own', () => {
  expect(label('walk:stride_length:left')).toBe('<measure_name.walk.stride_length>, left');
  expect(label('walk:double_support_share')).toBe('<measure_name.walk.double_support_share>');
});
