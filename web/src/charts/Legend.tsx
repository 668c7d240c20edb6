// Rows of a legend: a sample of what is drawn, and what it means in words.
import type { ReactNode, SVGProps } from 'react';

export function LegendRow({ sign, children }: { sign: ReactNode; children: ReactNode }) {
  return (
    <li>
      <svg width="34" height="14" aria-hidden>
        {sign}
      </svg>
      {children}
    </li>
  );
}

/** A row for a line that is drawn with this stroke. */
export function LegendStroke({ children, ...stroke }: Omit<SVGProps<SVGPathElement>, 'd' | 'ref'>) {
  return <LegendRow sign={<path d="M0 7h34" {...stroke} />}>{children}</LegendRow>;
}
