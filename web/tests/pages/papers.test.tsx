// Sheets laid out for the printer: once when the papers change, never at each key, and readable where a PDF is read aloud.
import { render } from '@testing-library/react';
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { withPrintStyles } from '../../src/lib/paper/printStyles';
import { Papers } from '../../src/pages/report/Papers';

let layouts = 0;
beforeEach(() => {
  layouts = 0;
  vi.useFakeTimers({ toFake: ['setTimeout', 'clearTimeout'] });
  vi.spyOn(HTMLElement.prototype, 'offsetHeight', 'get').mockImplementation(() => (layouts += 1));
  vi.spyOn(Element.prototype, 'getBoundingClientRect').mockImplementation(function (this: Element) {
    return { height: this.className === 'paper-area' ? 64 : 30 * this.querySelectorAll('p').length } as DOMRect;
  });
});
afterEach(() => {
  vi.useRealTimers();
  vi.restoreAllMocks();
});

/** Until observers have heard, and the quiet time is over. */
async function rest() {
  await Promise.resolve();
  vi.advanceTimersByTime(1000);
}

it('lays sheets out when something printed changes, and not while somebody types', async () => {
  const { container } = render(
    <Papers>
      <section className="paper">
        <p id="first">One</p>
        <p>Two</p>
        <p>Three</p>
        <div className="no-print">
          <textarea />
          <span>0 of 2000</span>
        </div>
      </section>
    </Papers>,
  );
  await rest();
  expect(layouts).toBe(1);
  const printed = document.querySelector('.papers-printed')!;
  expect(printed.children).toHaveLength(2);
  expect(printed.getAttribute('aria-hidden')).toBeNull();
  expect(document.querySelectorAll('#first')).toHaveLength(1);

  container.querySelector('span')!.textContent = '1 of 2000';
  await rest();
  expect(layouts).toBe(1);
  container.querySelector('textarea')!.focus();
  container.querySelector('p')!.textContent = 'One more';
  await rest();
  expect(layouts).toBe(1);
  container.querySelector('textarea')!.blur();
  await rest();
  expect(layouts).toBe(2);
  expect(printed.textContent).toContain('One more');
});

it('prints also where a style sheet of elsewhere shows its rules to nobody', () => {
  const foreign = {
    get cssRules(): CSSRuleList {
      throw new DOMException('not yours', 'SecurityError');
    },
  };
  vi.spyOn(document, 'styleSheets', 'get').mockReturnValue([foreign] as unknown as StyleSheetList);
  expect(withPrintStyles(() => 'done')).toBe('done');
});
