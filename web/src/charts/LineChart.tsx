// Several named lines on common axes, distinguished by colour and stroke, with a legend in words.
import { useMemo } from 'react';
import type uPlot from 'uplot';
import { LegendStroke } from './Legend';
import { plainTick } from '../lib/format';
import { axis, Plot, themeColour, type PlotOptions } from './Plot';
import { aligned, type Line } from './scales';

const DASHES: (readonly number[] | undefined)[] = [undefined, [9, 5], [3, 4], [12, 4, 3, 4], [6, 3], [2, 3]];
const COLOURS = 6;
// Without it uPlot writes numbers in the browser's language, which need not be the page's.
const values: uPlot.Axis.DynamicValues = (_, ticks) =>
  ticks.map((one: number | null) => (one === null ? '' : plainTick(one, 6)));

/** With more lines than colours a colour comes again, but never with the same stroke. */
const dashOf = (index: number) => DASHES[(index + Math.floor(index / COLOURS)) % DASHES.length];
const colourOf = (index: number): `--tm-${string}` => `--tm-series-${(index % COLOURS) + 1}`;

export interface LineChartProps {
  lines: readonly Line[];
  xTitle: string;
  yTitle: string;
  /** What the picture says, for those who do not see it. */
  label: string;
  logarithmic?: boolean;
  height?: number;
}

export function LineChart({ lines, xTitle, yTitle, label, logarithmic = false, height = 280 }: LineChartProps) {
  const data = useMemo(() => aligned(lines) as uPlot.AlignedData, [lines]);
  const names = lines.map((line) => line.name).join('\n');
  const options = useMemo<PlotOptions>(() => {
    const scale = logarithmic ? { distr: 3 as const, log: 10 as const } : {};
    const title = { labelSize: 26, labelFont: "14px 'Atkinson Hyperlegible Next Variable', system-ui, sans-serif" };
    return {
      cursor: { show: false },
      legend: { show: false },
      padding: [10, 30, 0, 0],
      scales: { x: { time: false, ...scale }, y: scale },
      axes: [axis({ size: 32, label: xTitle, values, ...title }), axis({ size: 62, label: yTitle, values, ...title })],
      series: [
        {},
        ...names.split('\n').map((_, index) => ({
          stroke: () => themeColour(colourOf(index)),
          width: 2,
          dash: dashOf(index) ? [...(dashOf(index) as number[])] : undefined,
          points: { show: false },
          spanGaps: false,
        })),
      ],
    };
  }, [names, xTitle, yTitle, logarithmic]);
  return (
    <div>
      <Plot options={options} data={data} height={height} label={label} />
      {lines.length > 1 && (
        <ul className="legend plain-list">
          {lines.map((line, index) => (
            <LegendStroke
              key={line.name}
              stroke={`var(${colourOf(index)})`}
              strokeWidth="3"
              strokeDasharray={dashOf(index)?.join(' ')}
            >
              {line.name}
            </LegendStroke>
          ))}
        </ul>
      )}
    </div>
  );
}
