// A report's papers on sheets: each with head, foot and number; nothing is lost, doubled or left without its heading.
import { beforeEach, expect, it, vi } from 'vitest';
import { layOut } from '../../src/lib/paper/sheets';

const HEAD = '<header class="paper-head"><h2 id="t">Progress report</h2><p>Amara Okafor</p></header>';
const FOOT = '<footer class="paper-foot"><span class="paper-number" data-words="page #">page 1</span></footer>';
/** Of a sheet, in the units of `heightOf`. */
const HEIGHT = 30;

/** A row, item or heading is one high, a figure ten, a text one for ten words. */
function heightOf(one: Element): number {
  if (one.tagName === 'FIGURE') return 10;
  if (one.tagName === 'P' && one.childElementCount === 0) return Math.ceil(one.textContent.split(' ').length / 10);
  if (['TR', 'LI', 'H2', 'H3', 'CAPTION', 'SPAN'].includes(one.tagName)) return 1;
  const heights = [...one.children].map(heightOf);
  return one.classList.contains('paper-ends') ? Math.max(0, ...heights) : heights.reduce((a, b) => a + b, 0);
}

beforeEach(() => {
  vi.spyOn(Element.prototype, 'getBoundingClientRect').mockImplementation(function (this: Element) {
    return { height: heightOf(this) } as DOMRect;
  });
});

function laidOut(...bodies: string[]): Element[] {
  const papers = document.createElement('div');
  papers.innerHTML = bodies.map((body) => `<section class="paper">${HEAD}${body}${FOOT}</section>`).join('');
  const into = document.createElement('div');
  expect(layOut(papers.children, into, HEIGHT)).toBe(into.childElementCount);
  for (const sheet of into.children) expect(heightOf(sheet)).toBeLessThanOrEqual(HEIGHT);
  return [...into.children];
}

const numbers = (sheets: Element[]) => sheets.map((one) => one.querySelector('.paper-number')?.textContent);
const words = (count: number) => Array.from({ length: count }, (_, index) => `w${index}`).join(' ');
const rows = (count: number) => Array.from({ length: count }, (_, index) => `<tr><td>r${index}</td></tr>`).join('');
const table = (count: number) =>
  `<h3>Measures</h3><table><caption>c</caption><thead><tr><th>head</th></tr></thead><tbody>${rows(count)}</tbody></table>`;
const found = (sheets: Element[], what: string) =>
  sheets.map((one) => [...one.querySelectorAll(what)].map((cell) => cell.textContent));

it('leaves papers that fit as they are', () => {
  const sheets = laidOut(table(5), '<figure></figure>');
  expect(numbers(sheets)).toEqual(['page 1', 'page 2']);
});

it('goes on with a long text on further sheets, word by word, and numbers all of them', () => {
  const sheets = laidOut(`<section><h3>Assessment</h3><p class="paper-words">${words(600)}</p></section>`, table(3));
  expect(numbers(sheets)).toEqual(sheets.map((_, index) => `page ${index + 1}`));
  expect(sheets.length).toBe(4);
  expect(sheets.every((one) => one.querySelector('.paper-head')?.textContent.includes('Amara Okafor'))).toBe(true);
  const text = sheets.flatMap((one) => [...one.querySelectorAll('.paper-words')].map((part) => part.textContent));
  expect(text.join('')).toBe(words(600));
  expect(sheets.every((one) => one.querySelector('[id]') === null)).toBe(true);
});

it('repeats the head of a table, and leaves none of its rows out', () => {
  const sheets = laidOut(table(60));
  expect(found(sheets, 'tbody td').flat()).toEqual(Array.from({ length: 60 }, (_, index) => `r${index}`));
  expect(found(sheets, 'thead').every(([head]) => head === 'head')).toBe(true);
});

it('begins no table with nothing but its head at the foot of a sheet', () => {
  const sheets = laidOut(`<figure></figure><figure></figure><p>${words(40)}</p>${table(8)}`);
  expect(found(sheets, 'h3')).toEqual([[], ['Measures']]);
  expect(found(sheets, 'thead')).toEqual([[], ['head']]);
  expect(found(sheets, 'tbody td')[1]).toHaveLength(8);
});

it('moves a figure whole, and columns side by side together', () => {
  const column =
    '<div class="paper-end"><h3>End</h3><figure></figure><figure></figure><ul><li>a</li><li>b</li></ul></div>';
  const sheets = laidOut(`<p>${words(40)}</p><div class="paper-ends">${column}${column}</div>`);
  expect(found(sheets, 'figure').map((one) => one.length)).toEqual([4]);
  const two = laidOut(`<p>${words(150)}</p><div class="paper-ends">${column}${column}</div>`);
  expect(found(two, 'figure').map((one) => one.length)).toEqual([2, 2]);
  expect(found(two, 'li')).toEqual([[], ['a', 'b', 'a', 'b']]);
});

it('leaves out what is not printed', () => {
  const sheets = laidOut('<button class="no-print">Write</button><section><p>x</p><i class="no-print">y</i></section>');
  expect(sheets[0]?.querySelector('button')).toBeNull();
});

it('leaves no heading behind when columns side by side begin overleaf', () => {
  const column = '<div class="paper-end"><figure></figure><figure></figure></div>';
  const sheets = laidOut(
    `<p>${words(190)}</p><section><h3>Ends</h3><div class="paper-ends">${column}${column}</div></section>`,
  );
  expect(found(sheets, 'h3')).toEqual([[], ['Ends']]);
  expect(found(sheets, '.paper-ends').map((one) => one.length)).toEqual([0, 1]);
  expect(found(sheets, 'figure').map((one) => one.length)).toEqual([0, 4]);
});

it('makes no sheet of a heading alone', () => {
  const column = `<div><div>${'<figure></figure>'.repeat(3)}</div></div>`;
  const papers = document.createElement('div');
  papers.innerHTML = `<section class="paper">${HEAD}<h3>Ends</h3><div class="paper-ends">${column}</div>${FOOT}</section>`;
  const into = document.createElement('div');
  layOut(papers.children, into, HEIGHT);
  expect(found([...into.children], 'h3')).toEqual([['Ends']]);
});

it('drops no words that stand beside elements, and no picture', () => {
  const sheets = laidOut(
    `<p>${words(200)}</p><div>Not measured: <span>${words(5)}</span><figure></figure></div>`,
    `<p>${words(200)}</p><div class="plot"><div><figure></figure></div><figure></figure></div>`,
    `<div>${words(600)}</div>`,
  );
  expect(sheets.map((one) => one.textContent).join('')).toContain('Not measured: w0 w1');
  expect(found(sheets, 'figure').flat()).toHaveLength(3);
  expect(sheets.map((one) => one.textContent).join('')).toContain('w599');
});

it('gives copies no identifiers but those that pictures draw with', () => {
  const [sheet] = laidOut(
    '<h3 id="title">Curve</h3><svg><clipPath id="cut"></clipPath><path id="p" clip-path="url(#cut)"></path></svg>',
  );
  expect([...sheet!.querySelectorAll('[id]')].map((one) => one.id)).toEqual(['cut']);
});
