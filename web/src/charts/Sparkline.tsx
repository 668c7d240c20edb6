// A small curve with its band for a line of a list.
import { t } from '../i18n';
import { quantity } from '../lib/format';
import { Chart } from './ChartFrame';
import { bandOf, lineOf } from './marks';
import { extent } from './scales';

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

const PAD = { top: 5, right: 5, bottom: 5, left: 5 };

export function Sparkline({ values, days, low, high, unit, label, width = 150, height = 44 }: SparklineProps) {
  const range = extent(values, low, high);
  if (values.length === 0 || !range) return <span className="muted small">{t('trend.none')}</span>;
  const along = days?.length === values.length ? days.map((one) => Date.parse(one)) : values.map((_, index) => index);
  const last = values.length - 1;
  return (
    <div style={{ flex: 'none', width, height }}>
      <Chart
        width={width}
        height={height}
        margin={PAD}
        label={t('trend.summary', {
          label,
          count: values.length,
          first: quantity(values[0], unit),
          last: quantity(values.at(-1), unit),
        })}
        x={{ domain: [along[0] ?? 0, along[last] ?? 1] }}
        y={{ domain: range }}
      >
        {(at) => {
          const x = (index: number) => at.x(along[index] ?? NaN);
          return (
            <>
              {low.length === values.length && <path className="chart-band-own" d={bandOf(low, high, x, at.y)} />}
              <path className="chart-line chart-line-strong" d={lineOf(values, x, at.y)} />
              <circle cx={x(last)} cy={at.y(values[last] ?? NaN)} r="4" fill="var(--tm-accent)" />
            </>
          );
        }}
      </Chart>
    </div>
  );
}
