// The papers of a report. Where they need more sheets than there are papers, what is printed is laid out beforehand.
import { useEffect, useRef, type ReactNode } from 'react';
import { withPrintStyles } from '../../lib/paper/printStyles';
import { layOut } from '../../lib/paper/sheets';

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

export function Papers({ children }: { children: ReactNode }) {
  const own = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const papers = own.current;
    if (!papers) return;
    const printed = document.createElement('div');
    printed.className = 'papers-printed';
    printed.setAttribute('aria-hidden', 'true');
    let timer: ReturnType<typeof setTimeout> | undefined;
    const now = () => {
      clearTimeout(timer);
      prepare(papers, printed);
    };
    const soon = () => {
      clearTimeout(timer);
      timer = setTimeout(now, QUIET_MS);
    };
    const watch = new MutationObserver(soon);
    watch.observe(papers, { childList: true, subtree: true, characterData: true });
    addEventListener('beforeprint', now);
    soon();
    return () => {
      clearTimeout(timer);
      watch.disconnect();
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
