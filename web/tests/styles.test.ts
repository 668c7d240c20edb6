// Style sheets: no rule of a class that nothing draws, and each sheet beside a component is loaded by it.
import { readdirSync, readFileSync } from 'node:fs';
import { basename, dirname, join } from 'node:path';
import { expect, it } from 'vitest';

const files = (pattern: RegExp) =>
  readdirSync('src', { recursive: true, encoding: 'utf8' })
    .filter((name) => pattern.test(name))
    .map((name) => join('src', name));
const sheets = files(/\.css$/);
const sources = files(/\.tsx?$/).map((name) => ({ name, text: readFileSync(name, 'utf8') }));
const code = sources.map((one) => one.text).join('\n');

/** Classes of a sheet, without those of the libraries. */
const classesOf = (sheet: string) =>
  [
    ...readFileSync(sheet, 'utf8')
      .replace(/\/\*[^]*?\*\//g, '')
      .matchAll(/\.([a-z][\w-]*)(?=[^{}]*\{)/gi),
  ]
    .map((found) => found[1] ?? '')
    .filter((name) => !/^(mantine-|u-|uplot)/.test(name));

/** Whether code names a class as a whole, or writes its beginning before a part that is computed. */
const isDrawn = (name: string, written: string) =>
  new RegExp(`(?<![\\w-])${name}(?![\\w-])`).test(written) ||
  name.split('-').some((_, parts, all) => parts > 0 && written.includes(`${all.slice(0, parts).join('-')}-\${`));

it('have no class that nothing draws', () => {
  const names = [...new Set(sheets.flatMap(classesOf))];
  expect(names.length).toBeGreaterThan(300);
  expect(names.filter((name) => !isDrawn(name, code))).toEqual([]);
});

it('would find one', () => {
  expect(isDrawn('band-key', '<p className="band-key-norm">')).toBe(false);
  expect(isDrawn('band-key-norm', 'className={`band-key-${kind}`}')).toBe(true);
});

it('beside components are loaded from their folder', () => {
  const beside = sheets.filter((sheet) => !sheet.startsWith('src/styles/'));
  const loaded = (sheet: string) =>
    sources.some(
      ({ name, text }) => dirname(name) === dirname(sheet) && text.includes(`import './${basename(sheet)}';`),
    );
  expect(beside.filter((sheet) => !loaded(sheet))).toEqual([]);
});
