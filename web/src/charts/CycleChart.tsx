// One quantity over the gait cycle: left and right with their bands, and a walk before as thin lines.
import { useMemo } from 'react';
import type uPlot from 'uplot';
import { LegendStroke } from './Legend';
import type { CycleCurve } from '../api/types';
import { t } from '../i18n';
import { displayUnit, plainTick, quantity } from '../lib/format';
import { axis, Plot, themeColour, type PlotOptions } from './Plot';

export interface CycleChartProps {
  name: string;
  left?: CycleCurve;
  right?: CycleCurve;
  beforeLeft?: CycleCurve;
  beforeRight?: CycleCurve;
  height?: number;
}

const PHASES = Array.from({ length: 51 }, (_, index) => 2 * index);
const NONE = PHASES.map(() => null);
const RIGHT_DASH = [8, 5];

export function CycleChart({ name, left, right, beforeLeft, beforeRight, height = 220 }: CycleChartProps) {
  const unit = (left ?? right)?.unit ?? '';
  const { factor } = displayUnit(unit);
  const data = useMemo<uPlot.AlignedData>(() => {
    const line = (curve: CycleCurve | undefined) => curve?.mean.map((value) => value * factor) ?? NONE;
    const edge = (curve: CycleCurve | undefined, sign: number) =>
      curve?.mean.map((value, index) => (value + sign * (curve.spread[index] ?? 0)) * factor) ?? NONE;
    return [
      PHASES,
      edge(left, 1),
      edge(left, -1),
      edge(right, 1),
      edge(right, -1),
      line(beforeLeft),
      line(beforeRight),
      line(left),
      line(right),
    ] as uPlot.AlignedData;
  }, [left, right, beforeLeft, beforeRight, factor]);
  const options = useMemo<PlotOptions>(() => {
    const hidden = { stroke: 'transparent', points: { show: false } };
    const before = (colour: `--tm-${string}`, dash?: number[]) => ({
      stroke: () => themeColour(colour),
      width: 1.2,
      dash,
      points: { show: false },
    });
    return {
      cursor: { show: false },
      legend: { show: false },
      padding: [10, 24, 0, 0],
      scales: { x: { time: false, range: [0, 100] } },
      axes: [
        axis({ size: 30, space: 60, values: (_, ticks) => ticks.map((tick) => `${tick} %`) }),
        axis({ size: 56, space: 38, values: (_, ticks) => ticks.map((tick) => plainTick(tick, 2)) }),
      ],
      series: [
        {},
        hidden,
        hidden,
        hidden,
        hidden,
        before('--tm-series-1'),
        before('--tm-series-2', [2, 3]),
        { stroke: () => themeColour('--tm-series-1'), width: 2.8, points: { show: false } },
        { stroke: () => themeColour('--tm-series-2'), width: 2.8, dash: RIGHT_DASH, points: { show: false } },
      ],
      bands: [
        { series: [1, 2], fill: () => themeColour('--tm-accent-band') },
        { series: [3, 4], fill: () => themeColour('--tm-neutral-band') },
      ],
    };
  }, []);
  const most = (curve: CycleCurve | undefined) => quantity(curve ? Math.max(...curve.mean) : null, unit);
  const suffix = displayUnit(unit).suffix.trim();
  return (
    <figure className="cycle">
      <figcaption>
        <span className="strong">{name}</span> {suffix && <span className="muted small">{suffix}</span>}
      </figcaption>
      <Plot
        options={options}
        data={data}
        height={height}
        label={t('cycle.summary', { name, left: most(left), right: most(right) })}
      />
    </figure>
  );
}

/** What the strokes mean, in words. */
export function CycleLegend({ hasBefore }: { hasBefore: boolean }) {
  return (
    <ul className="legend plain-list">
      <LegendStroke stroke="var(--tm-series-1)" strokeWidth="3">
        {t('cycle.left')}
      </LegendStroke>
      <LegendStroke stroke="var(--tm-series-2)" strokeWidth="3" strokeDasharray="8 5">
        {t('cycle.right')}
      </LegendStroke>
      {hasBefore && (
        <LegendStroke stroke="var(--tm-muted)" strokeWidth="1.2">
          {t('cycle.beforeLine')}
        </LegendStroke>
      )}
    </ul>
  );
}
