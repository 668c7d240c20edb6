// Divides a report's papers over sheets of A4, each with head, foot and a number of its own: browsers number no paper.

/** Said once at the top of a table; of a table that goes on overleaf again. */
const HEADS = new Set(['CAPTION', 'COLGROUP', 'THEAD']);
const DIVISIBLE = new Set(['TABLE', 'TBODY', 'UL', 'OL', 'DL', 'SECTION', 'DIV']);
const WHOLE = '.paper-facts, .paper-headline, .paper-method > div, .paper-legend';
/** Content without words. */
const PICTURES = 'svg, img, canvas, figure';
const FEWEST_WORDS = 12;

const isHeading = (one: Element | null): one is Element => one !== null && /^H[2-4]$/.test(one.tagName);
const isText = (one: Node): boolean => one.nodeType === Node.TEXT_NODE && one.textContent?.trim() !== '';
const isPicture = (one: Element): boolean => one.matches(PICTURES) || one.querySelector(PICTURES) !== null;
/** Holds nothing but what heads it. */
const isBare = (one: Element): boolean =>
  ![...one.childNodes].some(isText) &&
  [...one.children].every(
    (child) => HEADS.has(child.tagName) || (child.textContent.trim() === '' && !isPicture(child)),
  );
/** Whether all that it holds is in parts that can be placed one by one. */
const isDivisible = (one: Element): boolean =>
  DIVISIBLE.has(one.tagName) && !one.matches(WHOLE) && ![...one.childNodes].some(isText);
const isPlainText = (one: Element): boolean =>
  (one.tagName === 'P' || one.tagName === 'DIV') && one.childElementCount === 0 && [...one.childNodes].some(isText);

function shallow(source: Element): Element {
  const made = source.cloneNode(false) as Element;
  if (source.tagName === 'TABLE')
    made.append(...[...source.children].filter((one) => HEADS.has(one.tagName)).map((one) => one.cloneNode(true)));
  return made;
}

/** Fills sheets with what one paper holds. */
class Filler {
  readonly #paper: Element;
  readonly #into: Element;
  readonly #heightPx: number;
  #sheet!: Element;
  #foot: Element | null = null;
  /** What is divided at this moment, from outside in, and the part of each on this sheet. */
  #open: { source: Element; part: Element }[] = [];
  #hasContent = false;

  constructor(paper: Element, into: Element, heightPx: number) {
    this.#paper = paper;
    this.#into = into;
    this.#heightPx = heightPx;
  }

  fill(): void {
    this.#begin();
    for (const one of this.#paper.children) if (!one.matches('.paper-head, .paper-foot, .no-print')) this.#place(one);
  }

  #begin(): void {
    this.#sheet = this.#paper.cloneNode(false) as Element;
    this.#sheet.removeAttribute('aria-labelledby');
    const head = this.#paper.querySelector(':scope > .paper-head')?.cloneNode(true);
    this.#foot = (this.#paper.querySelector(':scope > .paper-foot')?.cloneNode(true) as Element | undefined) ?? null;
    this.#sheet.append(...[head, this.#foot].filter((one) => one !== undefined && one !== null));
    this.#into.append(this.#sheet);
    this.#hasContent = false;
  }

  #append(one: Element): void {
    const part = this.#open.at(-1)?.part;
    if (part) part.append(one);
    else this.#sheet.insertBefore(one, this.#foot);
  }

  #fits(): boolean {
    return this.#sheet.getBoundingClientRect().height <= this.#heightPx;
  }

  #tries(one: Element): boolean {
    this.#append(one);
    if (this.#fits()) {
      // A heading goes overleaf with what it heads: it alone makes no sheet.
      this.#hasContent ||= !isHeading(one);
      return true;
    }
    one.remove();
    return false;
  }

  #place(source: Element): void {
    if (source.matches('.no-print') || this.#tries(source.cloneNode(true) as Element)) return;
    if (source.matches('.paper-ends')) this.#columns(source);
    else if (isPlainText(source)) this.#words(source);
    else if (isDivisible(source)) this.#divide(source);
    else this.#overleaf(source);
  }

  /** On a new sheet; what is taller than a sheet stays as it is. */
  #overleaf(source: Element): void {
    if (this.#hasContent) this.#turn();
    if (this.#tries(source.cloneNode(true) as Element)) return;
    this.#append(source.cloneNode(true) as Element);
    this.#hasContent = true;
  }

  #divide(source: Element): void {
    const part = shallow(source);
    this.#append(part);
    this.#open.push({ source, part });
    for (const child of source.children) if (!HEADS.has(child.tagName)) this.#place(child);
    const last = this.#open.pop()?.part;
    if (last && isBare(last)) last.remove();
  }

  /** Begin another sheet in the midst of what is open; headings go with what they head. */
  #turn(): void {
    const headings: Element[][] = this.#open.map(() => []);
    headings.push([]);
    for (let level = this.#open.length; level >= 0; level -= 1) {
      const part = this.#open[level - 1]?.part;
      const last = () => (part ? part.lastElementChild : (this.#foot?.previousElementSibling ?? null));
      for (let one = last(); isHeading(one); one = last()) {
        headings[level]?.unshift(one);
        one.remove();
      }
      if (!part || !isBare(part)) break;
      part.remove();
    }
    const open = this.#open;
    this.#open = [];
    this.#begin();
    for (const one of headings[0] ?? []) this.#append(one);
    open.forEach(({ source }, index) => {
      const part = shallow(source);
      this.#append(part);
      this.#open.push({ source, part });
      for (const one of headings[index + 1] ?? []) this.#append(one);
    });
  }

  /** A text goes on overleaf at a word. */
  #words(source: Element): void {
    let rest = source.textContent.split(/(?<=\s)(?=\S)/);
    while (rest.length > 0) {
      const one = source.cloneNode(false) as Element;
      this.#append(one);
      const holds = (count: number) => {
        one.textContent = rest.slice(0, count).join('');
        return this.#fits();
      };
      let [most, tooMany] = [0, rest.length + 1];
      while (tooMany - most > 1) {
        const count = (most + tooMany) >> 1;
        if (holds(count)) most = count;
        else tooMany = count;
      }
      const isTooLittle = most < rest.length && most < FEWEST_WORDS;
      if (isTooLittle && this.#hasContent) {
        one.remove();
        this.#turn();
        continue;
      }
      const taken = isTooLittle ? rest.length : most;
      one.textContent = rest.slice(0, taken).join('');
      this.#hasContent = true;
      rest = rest.slice(taken);
      if (rest.length > 0) this.#turn();
    }
  }

  /** Columns side by side go on overleaf together. */
  #columns(source: Element): void {
    let columns: Element[] = [];
    let part: Element;
    const begin = () => {
      part = shallow(source);
      columns = [...source.children].map(shallow);
      part.append(...columns);
      this.#append(part);
    };
    begin();
    const rows = Math.max(...[...source.children].map((one) => one.childElementCount));
    for (let row = 0; row < rows; row += 1) {
      const cells = () =>
        columns.flatMap((column, index) => {
          const cell = source.children[index]?.children[row]?.cloneNode(true) as Element | undefined;
          if (cell) column.append(cell);
          return cell ? [cell] : [];
        });
      const placed = cells();
      if (!this.#fits() && this.#hasContent) {
        for (const one of placed) one.remove();
        const headings = columns.map((one) => (isHeading(one.lastElementChild) ? one.lastElementChild : null));
        for (const one of headings) one?.remove();
        if (columns.every(isBare)) part!.remove();
        this.#turn();
        begin();
        headings.forEach((one, index) => one && columns[index]?.append(one));
        cells();
      }
      this.#hasContent = true;
    }
  }
}

/** A copy has no identifiers of its own, but for what its pictures draw with: labels refer to the original. */
function stripIds(into: Element): void {
  const drawn = new Set([...into.innerHTML.matchAll(/url\((?:&quot;|["'])?#([^)"'&]+)/g)].map(([, id]) => id));
  for (const one of into.querySelectorAll('[id]')) if (!drawn.has(one.id)) one.removeAttribute('id');
}

/**
 * Lay papers out on sheets; returns how many there are.
 *
 * `into` must have the width of the paper's print area and the styles of print; `heightPx` is that area's height.
 */
export function layOut(papers: Iterable<Element>, into: Element, heightPx: number): number {
  into.replaceChildren();
  for (const paper of papers) new Filler(paper, into, heightPx).fill();
  stripIds(into);
  [...into.children].forEach((sheet, index) => {
    for (const one of sheet.querySelectorAll<HTMLElement>('.paper-number'))
      one.textContent = (one.dataset.words ?? '').replace('#', String(index + 1));
  });
  return into.childElementCount;
}
