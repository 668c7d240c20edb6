// A small curve with its band for a line of a list; a picture with words, no chart library.
import { useId } from 'react';
import { t } from '../i18n';
import { quantity } from '../lib/format';

export interface SparklineProps {
  values: readonly number[];
  /** Of each value, ISO 8601: how far apart they stand. Without them every value is a step. */
  days?: readonly string[];
  low: readonly number[];
  high: readonly number[];
  unit: string | null;
  label: string;
  width?: number;
  height?: number;
}

/** Where each value stands, 0 to 1: by its day, or one step after the other. */
export function places(count: number, days?: readonly string[]): number[] {
  const at = days?.length === count ? days.map((one) => Date.parse(one)) : Array.from({ length: count }, (_, i) => i);
  const first = at[0] ?? 0;
  const whole = (at.at(-1) ?? 0) - first || 1;
  return at.map((one) => (one - first) / whole);
}

/** Points of a polyline in the box, y up. */
export function polyline(
  values: readonly number[],
  along: readonly number[],
  minimum: number,
  maximum: number,
  width: number,
  height: number,
  pad: number,
): [number, number][] {
  const span = maximum - minimum || 1;
  return values.map((value, index) => [
    pad + (along[index] ?? 0) * (width - 2 * pad),
    height - pad - ((value - minimum) / span) * (height - 2 * pad),
  ]);
}

const path = (points: readonly [number, number][]) =>
  points.map(([x, y], index) => `${index ? 'L' : 'M'}${x.toFixed(1)} ${y.toFixed(1)}`).join('');

export function Sparkline({ values, days, low, high, unit, label, width = 150, height = 44 }: SparklineProps) {
  const title = useId();
  const finite = [...values, ...low, ...high].filter(Number.isFinite);
  if (values.length === 0 || finite.length === 0) return <span className="muted small">{t('trend.none')}</span>;
  const minimum = Math.min(...finite);
  const maximum = Math.max(...finite);
  const along = places(values.length, days);
  const place = (series: readonly number[]) => polyline(series, along, minimum, maximum, width, height, 5);
  const line = place(values);
  const band =
    low.length === values.length && high.length === values.length ? [...place(high), ...place(low).reverse()] : [];
  const last = line.at(-1);
  return (
    <svg
      width={width}
      height={height}
      viewBox={`0 0 ${width} ${height}`}
      role="img"
      aria-labelledby={title}
      style={{ flex: 'none' }}
    >
      <title id={title}>
        {t('trend.summary', {
          label,
          count: values.length,
          first: quantity(values[0], unit),
          last: quantity(values.at(-1), unit),
        })}
      </title>
      {band.length > 2 && <path d={`${path(band)}Z`} fill="var(--tm-accent-band)" />}
      <path
        d={path(line)}
        fill="none"
        stroke="var(--tm-accent)"
        strokeWidth="2.4"
        strokeLinejoin="round"
        strokeLinecap="round"
      />
      {last && <circle cx={last[0]} cy={last[1]} r="4" fill="var(--tm-accent)" />}
    </svg>
  );
}
