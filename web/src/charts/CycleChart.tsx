// One quantity over the gait cycle: left and right with their bands, and a walk before as thin lines.
import { LegendStroke } from './Legend';
import type { CycleCurve } from '../api/types';
import { t } from '../i18n';
import { displayUnit, plainTick, quantity } from '../lib/format';
import { ChartFrame, PERCENT, screenMargin, SHEET } from './ChartFrame';
import { bandOf, lineOf } from './marks';
import { extent } from './scales';

export interface CycleChartProps {
  name: string;
  left?: CycleCurve;
  right?: CycleCurve;
  beforeLeft?: CycleCurve;
  beforeRight?: CycleCurve;
  /** Of a sheet for paper. */
  isOnPaper?: boolean;
}

const SCREEN = { height: 220, margin: screenMargin() };

export function CycleChart({ name, left, right, beforeLeft, beforeRight, isOnPaper = false }: CycleChartProps) {
  const unit = (left ?? right)?.unit ?? '';
  const { factor } = displayUnit(unit);
  // The mean, and so many of its spreads away from it.
  const line = (curve: CycleCurve | undefined, spreads = 0) =>
    curve?.mean.map((value, index) => (value + spreads * (curve.spread[index] ?? 0)) * factor) ?? [];
  const bands = [left, right].map((curve) => [line(curve, -1), line(curve, 1)] as const);
  const before = [line(beforeLeft), line(beforeRight)];
  const most = (curve: CycleCurve | undefined) => quantity(curve ? Math.max(...curve.mean) : null, unit);
  return (
    <ChartFrame
      {...(isOnPaper ? SHEET : SCREEN)}
      label={t('cycle.summary', { name, left: most(left), right: most(right) })}
      x={{ ...PERCENT, hasLines: !isOnPaper }}
      y={{
        domain: extent(...bands.flat(), ...before) ?? [0, 1],
        isRound: true,
        every: 40,
        text: (at) => plainTick(at, 3),
      }}
    >
      {(at) => {
        // A value at every second per cent.
        const x = (index: number) => at.x(2 * index);
        return (
          <>
            {bands.map(([low, high], side) => (
              <path key={side} className={side ? 'chart-band' : 'chart-band-own'} d={bandOf(low, high, x, at.y)} />
            ))}
            {before.map((values, side) => (
              <path
                key={side}
                className={side ? 'cycle-before chart-right' : 'cycle-before'}
                d={lineOf(values, x, at.y)}
              />
            ))}
            <path className="chart-line chart-line-strong" d={lineOf(line(left), x, at.y)} />
            <path className="chart-line chart-line-strong chart-right" d={lineOf(line(right), x, at.y)} />
          </>
        );
      }}
    </ChartFrame>
  );
}

/** What the strokes mean, in words. */
export function CycleLegend({ hasBefore = false, className = 'legend' }: { hasBefore?: boolean; className?: string }) {
  return (
    <ul className={`${className} plain-list`}>
      <LegendStroke className="chart-line chart-line-strong">{t('cycle.left')}</LegendStroke>
      <LegendStroke className="chart-line chart-line-strong chart-right">{t('cycle.right')}</LegendStroke>
      {hasBefore && (
        <LegendStroke stroke="var(--tm-muted)" strokeWidth="1.2">
          {t('cycle.beforeLine')}
        </LegendStroke>
      )}
    </ul>
  );
}
