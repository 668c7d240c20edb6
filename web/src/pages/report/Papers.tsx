// The papers of a report. Where they need more sheets than there are papers, what is printed is laid out beforehand.
import { useEffect, useRef, type ReactNode } from 'react';
import { withPrintStyles } from '../../lib/paper/printStyles';
import { layOut } from '../../lib/paper/sheets';
import './Papers.css';
import './report.css';

/** After the last change: curves are drawn piece by piece. */
const QUIET_MS = 250;
/** Rounding of the printer's own layout. */
const SLACK_PX = 4;

function prepare(papers: HTMLElement, printed: HTMLElement): void {
  printed.remove();
  document.documentElement.classList.remove('has-sheets');
  // Nothing is laid out where nothing is shown.
  if (papers.offsetHeight === 0) return;
  const found = papers.querySelectorAll(':scope > .paper');
  const count = withPrintStyles(() => {
    printed.classList.add('is-measured');
    document.body.append(printed);
    const area = document.createElement('div');
    area.className = 'paper-area';
    printed.append(area);
    const heightPx = area.getBoundingClientRect().height - SLACK_PX;
    const sheets = layOut(found, printed, heightPx);
    printed.classList.remove('is-measured');
    return sheets;
  });
  if (count === found.length) printed.remove();
  else document.documentElement.classList.add('has-sheets');
}

const NO_PRINT = '.no-print';
const isUnprinted = (node: Node): boolean =>
  (node instanceof Element ? node : node.parentElement)?.closest(NO_PRINT) != null;

/** Whether something that is printed has changed. */
function changesPaper({ target, addedNodes, removedNodes }: MutationRecord): boolean {
  if (isUnprinted(target)) return false;
  const moved = [...addedNodes, ...removedNodes];
  return moved.length === 0 || moved.some((one) => !(one instanceof Element && one.matches(NO_PRINT)));
}

/** Whether somebody types here: to lay out all sheets takes longer than a key. */
function isTypedIn(papers: HTMLElement): boolean {
  const active = document.activeElement;
  return papers.contains(active) && (active?.matches('input, textarea, select, [contenteditable]') ?? false);
}

export function Papers({ children }: { children: ReactNode }) {
  const own = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const papers = own.current;
    if (!papers) return;
    const printed = document.createElement('div');
    printed.className = 'papers-printed';
    let timer: ReturnType<typeof setTimeout> | undefined;
    const now = () => {
      clearTimeout(timer);
      prepare(papers, printed);
    };
    const soon = () => {
      clearTimeout(timer);
      timer = setTimeout(() => !isTypedIn(papers) && now(), QUIET_MS);
    };
    const watch = new MutationObserver((changes) => changes.some(changesPaper) && soon());
    watch.observe(papers, { childList: true, subtree: true, characterData: true });
    // What was left out while somebody typed.
    papers.addEventListener('focusout', soon);
    addEventListener('beforeprint', now);
    soon();
    return () => {
      clearTimeout(timer);
      watch.disconnect();
      papers.removeEventListener('focusout', soon);
      removeEventListener('beforeprint', now);
      printed.remove();
      document.documentElement.classList.remove('has-sheets');
    };
  }, []);
  return (
    <div className="papers" ref={own}>
      {children}
    </div>
  );
}
