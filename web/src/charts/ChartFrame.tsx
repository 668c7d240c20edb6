// The frame of every drawn chart: its size, scales, both axes, and what it says in words.
import { useElementSize } from '@mantine/hooks';
import { scaleLinear, scaleLog, type ScaleContinuousNumeric } from 'd3-scale';
import type { CSSProperties, MouseEvent, ReactNode } from 'react';
import './ChartFrame.css';

export type Scale = ScaleContinuousNumeric<number, number>;

export interface Axis {
  domain: readonly [number, number];
  /** The number at a value; without it the axis has neither numbers nor lines. */
  text?: (value: number) => string;
  /** About so many pixels from number to number. */
  every?: number;
  /** Where numbers stand; without it at round values. */
  ticks?: (scale: Scale) => readonly number[];
  hasLines?: boolean;
  /** Extended to round values. */
  isRound?: boolean;
  isLogarithmic?: boolean;
  title?: string;
}

export interface Margin {
  top: number;
  right: number;
  bottom: number;
  left: number;
}

/** Scales of a chart, and the edges of its plot in pixels. */
export interface Place extends Margin {
  x: Scale;
  y: Scale;
  width: number;
  height: number;
}

export interface ChartProps {
  width: number;
  height: number;
  margin: Margin;
  x: Axis;
  y: Axis;
  /** What the picture says, for those who do not see it. */
  label: string;
  /** A group has parts that can be reached. */
  role?: 'img' | 'group';
  /** Under the axes. */
  behind?: (at: Place) => ReactNode;
  children: (at: Place) => ReactNode;
  /** Pressed at these pixels; a keyboard has another way to the same. */
  onPoint?: (x: number, y: number, at: Place) => void;
}

const EVERY = 48;
const LETTER = 7;

function scaleOf({ domain, isLogarithmic, isRound, every = EVERY }: Axis, from: number, to: number): Scale {
  const scale = isLogarithmic ? scaleLog() : scaleLinear();
  scale.domain(domain).range([from, to]);
  return isRound ? scale.nice(countOf(every, from, to)) : scale;
}

const countOf = (every: number, from: number, to: number) => Math.max(2, Math.floor(Math.abs(to - from) / every));

/** Where the numbers of an axis stand: round values, on a logarithmic axis those that begin with 1, 2 or 5, or with 1. */
function ticksOf({ ticks, every = EVERY, isLogarithmic }: Axis, scale: Scale): readonly number[] {
  if (ticks) return ticks(scale);
  const [from = 0, to = 0] = scale.range();
  const count = countOf(every, from, to);
  const all = scale.ticks(count);
  if (!isLogarithmic || all.length <= count) return all;
  const beginning = (digits: string) => all.filter((one) => digits.includes(one.toExponential().charAt(0)));
  const few = beginning('125');
  return few.length <= count ? few : beginning('1');
}

function XAxis({ axis, at }: { axis: Axis; at: Place }) {
  const { text } = axis;
  if (!text) return null;
  return ticksOf(axis, at.x).map((value) => {
    const place = at.x(value);
    const words = text(value);
    const half = (words.length * LETTER) / 2;
    const isLast = place + half > at.width - 2;
    return (
      <g key={value}>
        {axis.hasLines && <path d={`M${place} ${at.top}V${at.bottom}`} />}
        <text
          x={isLast ? at.width - 2 : Math.max(place, half)}
          y={at.bottom + 21}
          textAnchor={isLast ? 'end' : 'middle'}
        >
          {words}
        </text>
      </g>
    );
  });
}

function YAxis({ axis, at }: { axis: Axis; at: Place }) {
  const { text } = axis;
  if (!text) return null;
  return ticksOf(axis, at.y).map((value) => (
    <g key={value}>
      {axis.hasLines !== false && <path d={`M${at.left} ${at.y(value)}H${at.right}`} />}
      <text x={at.left - 6} y={at.y(value) + 4} textAnchor="end">
        {text(value)}
      </text>
    </g>
  ));
}

/** A chart of a known width. */
export function Chart({ width, height, margin, x, y, label, role = 'img', behind, children, onPoint }: ChartProps) {
  const edges = { top: margin.top, left: margin.left, right: width - margin.right, bottom: height - margin.bottom };
  const at: Place = {
    ...edges,
    width,
    height,
    x: scaleOf(x, edges.left, edges.right),
    y: scaleOf(y, edges.bottom, edges.top),
  };
  const press = (event: MouseEvent<SVGSVGElement>) => {
    const box = event.currentTarget.getBoundingClientRect();
    onPoint?.(event.clientX - box.left, event.clientY - box.top, at);
  };
  return (
    <svg
      className={onPoint ? 'chart chart-pressed' : 'chart'}
      viewBox={`0 0 ${width} ${height}`}
      role={role}
      aria-label={label}
      onClick={onPoint && press}
    >
      {behind?.(at)}
      <g className="chart-axes" aria-hidden>
        <XAxis axis={x} at={at} />
        <YAxis axis={y} at={at} />
        {x.title && (
          <text x={(at.left + at.right) / 2} y={height - 8} textAnchor="middle">
            {x.title}
          </text>
        )}
        {y.title && (
          <text transform={`translate(16 ${(at.top + at.bottom) / 2}) rotate(-90)`} textAnchor="middle">
            {y.title}
          </text>
        )}
      </g>
      {children(at)}
    </svg>
  );
}

/** Before its place is measured. */
const FIRST_WIDTH = 820;
const NARROWEST = 220;

/** A chart as wide as its place; with `widest` at most so wide, and larger in print, as a sheet needs it. */
export function ChartFrame({ widest, ...chart }: Omit<ChartProps, 'width'> & { widest?: number }) {
  const { ref, width: measured } = useElementSize<HTMLDivElement>();
  const width =
    measured > 0 ? Math.max(NARROWEST, Math.min(widest ?? Infinity, Math.round(measured))) : (widest ?? FIRST_WIDTH);
  const style = widest ? { '--own': `${width}px` } : { height: chart.height };
  return (
    <div ref={ref} className={widest ? 'chart-frame chart-sheet' : 'chart-frame'} style={style as CSSProperties}>
      <Chart {...chart} width={width} />
    </div>
  );
}

/** Margins of a chart on a screen: with room for numbers of four digits, or with their unit. */
export const screenMargin = (suffix = ''): Margin => ({
  top: 10,
  right: 24,
  bottom: 30,
  left: suffix.length > 2 ? 84 : 56,
});

/** Margins of a chart on a sheet; the plot is as high and wide as on every other one. */
export const SHEET_MARGIN: Margin = { top: 12, right: 12, bottom: 30, left: 44 };

/** A movement or a gait cycle on a sheet, at most; two stand side by side. */
export const SHEET = { widest: 380, height: 210, margin: SHEET_MARGIN };

/** Per cent of a movement or a gait cycle. */
export const PERCENT: Axis = { domain: [0, 100], text: (value) => `${value} %`, every: 80, hasLines: true };
