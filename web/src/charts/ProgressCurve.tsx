// One measure over time, drawn: its line with its spread, bands across, and the days on which something happened.
import type { ProgressEvent, ProgressMeasure } from '../api/types';
import { t } from '../i18n';
import { date, displayUnit, plainTick, quantity, tick } from '../lib/format';
import type { Day } from '../lib/assessment/days';
import { ChartFrame, SHEET_MARGIN, type Margin, type Place } from './ChartFrame';
import { bandOf, lineOf } from './marks';
import { extent } from './scales';
import './ProgressCurve.css';

const HALF_DAY_S = 43_200;
/** Room of a date under the axis. */
const DATE_PX = 76;
/** So far from one another numbers above the picture can be read. */
const PIN_PX = 16;

const seconds = (at: string) => new Date(at).getTime() / 1000;

/** The other side, and published values: across the whole picture, behind everything else. */
function Across({ bands, factor, at }: { bands: ProgressMeasure['bands']; factor: number; at: Place }) {
  return bands.map(({ kind, low, high }) => {
    const top = at.y(high * factor);
    const height = Math.max(at.y(low * factor) - top, 2);
    return (
      <g key={kind} className={`progress-band progress-band-${kind}`}>
        <rect x={at.left} y={top} width={at.right - at.left} height={height} />
        <path d={`M${at.left} ${top}H${at.right}M${at.left} ${top + height}H${at.right}`} />
      </g>
    );
  });
}

/** A line for each day on which something happened, with its number in the strip above the charts. */
function Pins({ days, at }: { days: readonly ProgressEvent[][]; at: Place }) {
  let named = -Infinity;
  return days.map((day, index) => {
    const x = at.x(seconds(day[0]?.at ?? ''));
    if (!(x >= at.left && x <= at.right)) return null;
    const hasNumber = x - named >= PIN_PX;
    if (hasNumber) named = x;
    return (
      <g key={day[0]?.at} className="progress-pin">
        <path d={`M${x} ${at.top + 4}V${at.bottom}`} />
        {hasNumber && (
          <text x={x} y={at.top - 4} textAnchor="middle">
            {index + 1}
          </text>
        )}
      </g>
    );
  });
}

/** Noon of whole days, evenly: two numbers may not show the same date, nor touch. */
function noons([low = 0, high = 0]: readonly number[], room: number): number[] {
  const days = Math.max(1, Math.round((high - low) / (2 * HALF_DAY_S)));
  const most = Math.min(6, Math.max(1, Math.floor(room / DATE_PX)));
  const every = Math.max(1, Math.ceil(days / most));
  const start = new Date(low * 1000);
  const first = new Date(start.getFullYear(), start.getMonth(), start.getDate() + 1).getTime() / 1000 + HALF_DAY_S;
  return Array.from({ length: Math.ceil(days / every) }, (_, index) => first + index * every * 2 * HALF_DAY_S).filter(
    (at) => at <= high,
  );
}

/** The first and the last moment, and those between that leave room for their neighbours. */
function roomy(times: readonly number[], x: (atS: number) => number): number[] {
  const last = times.at(-1) ?? 0;
  return times.reduce<number[]>((named, at, index) => {
    const isBetween = x(at) - x(named.at(-1) ?? 0) >= DATE_PX && x(last) - x(at) >= DATE_PX;
    return index === 0 || index === times.length - 1 || isBetween ? [...named, at] : named;
  }, []);
}

export interface ProgressCurveProps {
  points: readonly Pick<Day, 'atS' | 'value' | 'low' | 'high'>[];
  unit: string | null;
  label: string;
  height: number;
  margin: Margin;
  /** Of a sheet for paper: at most so wide. */
  widest?: number;
  bands?: ProgressMeasure['bands'];
  happened?: readonly ProgressEvent[][];
  /** Whether a point is of the session that is spoken of. */
  isHere?: (index: number) => boolean;
  onPoint?: (index: number) => void;
}

const NO_BANDS: ProgressMeasure['bands'] = [];

/** One measure over time: its line with its spread, a mark for each point. */
export function ProgressCurve({
  points,
  unit: name,
  bands = NO_BANDS,
  happened = [],
  isHere,
  onPoint,
  ...size
}: ProgressCurveProps) {
  const unit = displayUnit(name);
  const scaled = (pick: (point: ProgressCurveProps['points'][number]) => number) =>
    points.map((point) => pick(point) * unit.factor);
  const [low, high, values] = [scaled((one) => one.low), scaled((one) => one.high), scaled((one) => one.value)];
  const all = [...low, ...high, ...values, ...bands.flatMap((one) => [one.low * unit.factor, one.high * unit.factor])];
  const [least, most] = extent(all) ?? [0, 1];
  const isSheet = size.widest !== undefined;
  // A spread of little meaning must not fill the picture.
  const span = unit.suffix === '°' ? 10 : 0;
  const pad = isSheet ? 0 : Math.max((most - least) * 0.18, (span - (most - least)) / 2, 1e-3);
  const rim = isSheet ? 0 : HALF_DAY_S;
  const times = points.map((one) => one.atS);
  const [firstS, lastS] = [times[0] ?? 0, times.at(-1) ?? 1];
  return (
    <ChartFrame
      {...size}
      x={{
        domain: [firstS - rim, lastS + rim],
        text: (at) => date(new Date(at * 1000)),
        ticks: (x) => {
          const [from = 0, to = 0] = x.range();
          return isSheet ? roomy(times, x) : noons(x.domain(), to - from);
        },
      }}
      y={{
        domain: [least - pad, most + pad],
        isRound: isSheet,
        every: isSheet ? 32 : 44,
        text: (at) => (isSheet ? plainTick(at, 3) + (unit.suffix === '°' ? '°' : '') : tick(at, unit)),
      }}
      behind={(at) => (
        <>
          <Across bands={bands} factor={unit.factor} at={at} />
          <Pins days={happened} at={at} />
        </>
      )}
      onPoint={
        onPoint &&
        ((x, _, at) => {
          const away = times.map((one) => Math.abs(at.x(one) - x));
          onPoint(away.indexOf(Math.min(...away)));
        })
      }
    >
      {(at) => {
        const x = (index: number) => at.x(times[index] ?? NaN);
        return (
          <>
            <path className="chart-band-own" d={bandOf(low, high, x, at.y)} />
            <path className="chart-line chart-line-strong" d={lineOf(values, x, at.y)} />
            {values.map((value, index) => (
              <circle
                key={times[index]}
                className={isHere?.(index) ? 'chart-point chart-point-here' : 'chart-point'}
                cx={x(index)}
                cy={at.y(value)}
                r={isSheet ? 3.6 : 5}
              />
            ))}
          </>
        );
      }}
    </ChartFrame>
  );
}

const SHEET = { widest: 720, height: 170, margin: SHEET_MARGIN };

/** One measure over the sessions on a sheet, which is as wide as it and holds a table below. */
export function PaperProgress({ measure, sessionId }: { measure: ProgressMeasure; sessionId: string }) {
  const { points } = measure;
  return (
    <ProgressCurve
      {...SHEET}
      points={points.map((one) => ({ ...one, atS: seconds(one.at) }))}
      unit={measure.unit}
      label={t('report.progressLabel', {
        label: measure.label,
        count: points.length,
        first: quantity(points[0]?.value, measure.unit),
        last: quantity(points.at(-1)?.value, measure.unit),
      })}
      isHere={(index) => points[index]?.session_id === sessionId}
    />
  );
}
