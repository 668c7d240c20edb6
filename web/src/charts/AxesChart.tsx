// Three axes of one sensor over time, small: enough to see at a glance whether the signals are what they are taken for.
import { useMemo } from 'react';
import type uPlot from 'uplot';
import { LegendStroke } from './Legend';
import { number, plainTick } from '../lib/format';
import { axis, Plot, themeColour, type PlotOptions } from './Plot';
import { extent } from './scales';

const AXES = ['x', 'y', 'z'] as const;
const colourOf = (index: number): `--tm-${string}` => `--tm-series-${index + 1}`;
const HEIGHT = 132;

export interface AxesChartProps {
  timeS: readonly number[];
  /** x, y and z; null makes a hole. */
  axes: readonly (readonly (number | null)[])[];
  /** As it is shown: what the values are multiplied by, and the unit's name. */
  factor: number;
  unit: string;
  name: string;
  /** What the picture says, for those who do not see it. */
  label: (lowest: string, highest: string) => string;
}

export function AxesChart({ timeS, axes, factor, unit, name, label }: AxesChartProps) {
  const data = useMemo(
    () =>
      [timeS, ...axes.map((one) => one.map((value) => (value === null ? null : value * factor)))] as uPlot.AlignedData,
    [timeS, axes, factor],
  );
  const options = useMemo<PlotOptions>(
    () => ({
      cursor: { show: false },
      legend: { show: false },
      padding: [8, 14, 0, 0],
      scales: { x: { time: false, range: (_, low, high) => [low, high] } },
      axes: [
        axis({ size: 24, space: 60, values: (_, ticks) => ticks.map((one: number) => `${plainTick(one, 1)} s`) }),
        axis({ size: 52, space: 20, values: (_, ticks) => ticks.map((one: number) => plainTick(one, 2)) }),
      ],
      series: [
        {},
        ...AXES.map((_, index) => ({
          stroke: () => themeColour(colourOf(index)),
          width: 1.8,
          points: { show: false },
          spanGaps: false,
        })),
      ],
    }),
    [],
  );
  const range = extent(...axes) ?? [NaN, NaN];
  const said = (value: number) => `${number(value * factor, Math.abs(value * factor) < 10 ? 1 : 0)} ${unit}`;
  return (
    <figure className="axes-chart">
      <figcaption>
        <span className="strong">{name}</span> <span className="muted">{unit}</span>
      </figcaption>
      <Plot options={options} data={data} height={HEIGHT} label={label(said(range[0]), said(range[1]))} />
    </figure>
  );
}

/** Which colour is which axis. */
export function AxesLegend() {
  return (
    <ul className="legend plain-list">
      {AXES.map((one, index) => (
        <LegendStroke key={one} stroke={`var(${colourOf(index)})`} strokeWidth="3">
          {one}
        </LegendStroke>
      ))}
    </ul>
  );
}
