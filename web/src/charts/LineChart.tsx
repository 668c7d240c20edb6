// Several named lines on common axes, distinguished by colour and stroke, with a legend in words.
import { useMemo } from 'react';
import { LegendStroke } from './Legend';
import { plainTick } from '../lib/format';
import { ChartFrame, type Axis } from './ChartFrame';
import { lineOf } from './marks';
import { extent } from './scales';

/** A named line; null makes a hole in it. */
export interface Line {
  name: string;
  x: readonly (number | null)[];
  y: readonly (number | null)[];
}

const DASHES = [undefined, '9 5', '3 4', '12 4 3 4', '6 3', '2 3'];
const COLOURS = 6;

/** With more lines than colours a colour comes again, but never with the same stroke. */
const strokeOf = (index: number) => ({
  stroke: `var(--tm-series-${(index % COLOURS) + 1})`,
  strokeDasharray: DASHES[(index + Math.floor(index / COLOURS)) % DASHES.length],
});

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
  const [xs, ys] = useMemo(() => {
    // A logarithmic axis has no place for zero.
    const placed = (values: Line['x']) => values.map((one) => (logarithmic && !(one !== null && one > 0) ? null : one));
    return [lines.map((line) => placed(line.x)), lines.map((line) => placed(line.y))] as const;
  }, [lines, logarithmic]);
  const axis = (values: readonly Line['x'][], title: string, more?: Partial<Axis>): Axis => ({
    domain: extent(...values) ?? [1, 10],
    text: (value) => plainTick(value, 6),
    isLogarithmic: logarithmic,
    title,
    ...more,
  });
  return (
    <div>
      <ChartFrame
        height={height}
        margin={{ top: 10, right: 30, bottom: 58, left: 88 }}
        label={label}
        x={axis(xs, xTitle, { hasLines: true, every: 60, isRound: logarithmic })}
        y={axis(ys, yTitle, { isRound: true, every: 40 })}
      >
        {(at) =>
          lines.map((line, index) => (
            <path
              key={line.name}
              {...strokeOf(index)}
              fill="none"
              strokeWidth="2"
              d={lineOf(
                (ys[index] ?? []).map((value, point) => (xs[index]?.[point] === null ? null : value)),
                (point) => at.x(xs[index]?.[point] ?? NaN),
                at.y,
              )}
            />
          ))
        }
      </ChartFrame>
      {lines.length > 1 && (
        <ul className="legend plain-list">
          {lines.map((line, index) => (
            <LegendStroke key={line.name} {...strokeOf(index)} strokeWidth="3">
              {line.name}
            </LegendStroke>
          ))}
        </ul>
      )}
    </div>
  );
}
