// Three axes of one sensor over time, small: enough to see at a glance whether the signals are what they are taken for.
import { LegendStroke } from './Legend';
import { number, plainTick } from '../lib/format';
import { ChartFrame, screenMargin } from './ChartFrame';
import { lineOf } from './marks';
import { extent } from './scales';
import './AxesChart.css';

const AXES = ['x', 'y', 'z'] as const;
const strokeOf = (index: number) => `var(--tm-series-${index + 1})`;

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
  const [low, high] = extent(...axes) ?? [NaN, NaN];
  const said = (value: number) => `${number(value * factor, Math.abs(value * factor) < 10 ? 1 : 0)} ${unit}`;
  return (
    <figure className="axes-chart">
      <figcaption>
        <span className="strong">{name}</span> <span className="muted">{unit}</span>
      </figcaption>
      <ChartFrame
        height={132}
        margin={{ ...screenMargin(), top: 8, right: 14 }}
        label={label(said(low), said(high))}
        x={{
          domain: extent(timeS) ?? [0, 1],
          text: (value) => `${plainTick(value, 1)} s`,
          every: 60,
          hasLines: true,
        }}
        y={{
          domain: Number.isFinite(low) ? [low * factor, high * factor] : [0, 1],
          text: (value) => plainTick(value, 2),
          every: 30,
          isRound: true,
        }}
      >
        {(at) =>
          axes.map((values, index) => (
            <path
              key={AXES[index]}
              fill="none"
              stroke={strokeOf(index)}
              strokeWidth="1.8"
              d={lineOf(
                values,
                (point) => at.x(timeS[point] ?? NaN),
                (value) => at.y(value * factor),
              )}
            />
          ))
        }
      </ChartFrame>
    </figure>
  );
}

/** Which colour is which axis. */
export function AxesLegend() {
  return (
    <ul className="legend plain-list">
      {AXES.map((one, index) => (
        <LegendStroke key={one} stroke={strokeOf(index)} strokeWidth="3">
          {one}
        </LegendStroke>
      ))}
    </ul>
  );
}
