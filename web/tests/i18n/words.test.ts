import { readdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { expect, it } from 'vitest';
import { isKey, t } from '../../src/i18n';
import { words as en } from '../../src/i18n/en';

const sources = readdirSync('src', { recursive: true, encoding: 'utf8' })
  .filter((name) => /\.tsx?$/.test(name) && !name.startsWith('i18n') && !name.includes('schema'))
  .map((name) => readFileSync(join('src', name), 'utf8'))
  .join('\n');

it('puts parameters in and follows the plural', () => {
  expect(t('caseload.lead', { count: 1 })).toBe('1 patient needs attention');
  expect(t('caseload.lead', { count: 3 })).toBe('3 patients need attention');
  expect(isKey('no.such.key')).toBe(false);
});

it('has no words that no page uses', () => {
  // Keys that are put together at run time begin with one of these.
  const joined = [...sources.matchAll(/t(?:Or)?\(`([^$`]+)\$\{/g)].map((match) => match[1] ?? '');
  const unused = Object.keys(en).filter(
    (key) => !sources.includes(`'${key}'`) && !joined.some((start) => key.startsWith(start)),
  );
  expect(unused).toEqual([]);
});
