// Charts for paper: drawn as vectors, sharp at any size, in the colours of the sheet they stand on. On a narrow screen they
// are drawn as narrow, not shrunk: their words stay as large as those around them.
import { useElementSize } from '@mantine/hooks';
import type { CSSProperties, ReactNode } from 'react';
import type { CycleCurve, PhaseCurve, PhaseDesign, ProgressMeasure } from '../api/types';
import { t } from '../i18n';
import { aboutZero, bandEdges, type OutsideStretch } from '../lib/assessment/comparison';
import { date, displayUnit, plainTick, quantity } from '../lib/format';
import { extent, niceTicks } from './scales';

interface Size {
  width: number;
  height: number;
}

/** At most; one movement from 0 to 100 %: two stand side by side. */
const PHASES: Size = { width: 380, height: 210 };
/** At most; days and weeks: as wide as the sheet, and low, for a table follows. */
const DAYS: Size = { width: 720, height: 170 };
const LEFT = 44;
const RIGHT = 12;
const TOP = 12;
const BOTTOM = 30;
const LABEL = 74;
const NARROWEST = 220;
/** Height of the bars that mark where a repetition is outside its band. */
const BAR = PHASES.height - BOTTOM + 5;

/** A picture as wide as its place, up to its full size; before its place is known, and where there is none, of full size. */
function Picture({ full, label, children }: { full: Size; label: string; children: (size: Size) => ReactNode }) {
  const { ref, width } = useElementSize<HTMLDivElement>();
  const own = width > 0 ? Math.max(NARROWEST, Math.min(full.width, Math.round(width))) : full.width;
  return (
    <div ref={ref} className="paper-picture" style={{ '--own': `${own}px` } as CSSProperties}>
      <svg className="paper-chart" viewBox={`0 0 ${own} ${full.height}`} role="img" aria-label={label}>
        {children({ width: own, height: full.height })}
      </svg>
    </div>
  );
}

type Values = readonly (number | null)[];

interface Frame extends Size {
  x: (value: number) => number;
  y: (value: number) => number;
  ticks: number[];
}

function frame({ width, height }: Size, low: number, high: number, first: number, last: number): Frame {
  const ticks = niceTicks(low, high, 4);
  const bottom = Math.min(low, ticks[0] ?? low);
  const top = Math.max(high, ticks.at(-1) ?? high);
  return {
    width,
    height,
    x: (value) => LEFT + ((value - first) / (last - first || 1)) * (width - LEFT - RIGHT),
    y: (value) => TOP + (1 - (value - bottom) / (top - bottom || 1)) * (height - TOP - BOTTOM),
    ticks,
  };
}

/** A line through the known values; a gap stays a gap. */
export function pathOf(values: Values, x: (index: number) => number, y: (value: number) => number): string {
  let isDown = false;
  let path = '';
  values.forEach((value, index) => {
    if (value === null || !Number.isFinite(value)) {
      isDown = false;
      return;
    }
    path += `${isDown ? 'L' : 'M'}${x(index).toFixed(1)} ${y(value).toFixed(1)}`;
    isDown = true;
  });
  return path;
}

function bandOf(low: Values, high: Values, x: (index: number) => number, y: (value: number) => number): string {
  const there = low.flatMap((value, index) =>
    value !== null && high[index] !== null && high[index] !== undefined ? [index] : [],
  );
  if (there.length < 2) return '';
  const upper = there.map((index) => `${x(index).toFixed(1)} ${y(high[index] as number).toFixed(1)}`);
  const lower = there.reverse().map((index) => `${x(index).toFixed(1)} ${y(low[index] as number).toFixed(1)}`);
  return `M${[...upper, ...lower].join('L')}Z`;
}

function Axes({ at, suffix, xTicks }: { at: Frame; suffix: string; xTicks: { at: number; text: string }[] }) {
  return (
    <g className="paper-axes">
      {at.ticks.map((tick) => (
        <g key={tick}>
          <path d={`M${LEFT} ${at.y(tick)}H${at.width - RIGHT}`} />
          <text x={LEFT - 6} y={at.y(tick) + 4} textAnchor="end">
            {plainTick(tick, 3) + suffix}
          </text>
        </g>
      ))}
      {xTicks.map((tick, index) => (
        <text
          key={tick.text}
          x={tick.at}
          y={at.height - 9}
          textAnchor={index === 0 && tick.at <= LEFT + 1 ? 'start' : tick.at >= at.width - RIGHT - 1 ? 'end' : 'middle'}
        >
          {tick.text}
        </text>
      ))}
    </g>
  );
}

/** Stretches joined where they touch or overlap, in order. */
export function joined(stretches: readonly { from: number; until: number }[]): { from: number; until: number }[] {
  const found: { from: number; until: number }[] = [];
  for (const { from, until } of [...stretches].sort((a, b) => a.from - b.from)) {
    const last = found.at(-1);
    if (last && from <= last.until) last.until = Math.max(last.until, until);
    else found.push({ from, until });
  }
  return found;
}

const LETTER = 7;

/** A name that fits into so many points; the beginning of it where it does not. */
function fitted(name: string, room: number): string {
  const letters = Math.floor(room / LETTER);
  return name.length <= letters ? name : `${name.slice(0, Math.max(1, letters - 1))}…`;
}

/** One channel over the phases: template with band, every repetition that counts, thick and barred where it leaves the band. */
export function PaperPhases({
  curve: measured,
  left,
  outside = [],
  phases = [],
}: {
  curve: PhaseCurve;
  left: ReadonlySet<number>;
  outside?: readonly OutsideStretch[];
  phases?: readonly PhaseDesign[];
}) {
  const curve = aboutZero(measured);
  const unit = displayUnit(curve.unit);
  const scaled = (values: Values) => values.map((value) => (value === null ? null : value * unit.factor));
  const edges = bandEdges(curve);
  const low = scaled(edges.low);
  const high = scaled(edges.high);
  const mean = scaled(curve.mean);
  const repetitions = curve.repetitions.map(scaled).filter((_, index) => !left.has(index));
  const range = extent(low, high, mean, ...repetitions) ?? [0, 1];
  const own = extent(...repetitions);
  const label = t('report.phaseLabel', {
    label: curve.label,
    low: quantity(own ? own[0] / unit.factor : null, curve.unit),
    high: quantity(own ? own[1] / unit.factor : null, curve.unit),
  });
  const drawn = (size: Size) => {
    const at = frame(size, range[0], range[1], 0, 100);
    return (
      <>
        <Axes
          at={at}
          suffix={unit.suffix === '°' ? '°' : ''}
          xTicks={[0, 25, 50, 75, 100].map((phase) => ({ at: at.x(phase), text: `${phase} %` }))}
        />
        <path className="paper-band" d={bandOf(low, high, at.x, at.y)} />
        {phases.map(({ name, start, end }) => (
          <g key={start} className="paper-phase">
            {start > 0 && <path d={`M${at.x(100 * start).toFixed(1)} ${TOP}V${at.height - BOTTOM}`} />}
            <text x={at.x(50 * (start + end))} y={TOP - 2} textAnchor="middle">
              {fitted(name, at.x(100 * end) - at.x(100 * start))}
            </text>
          </g>
        ))}
        {repetitions.map((values, index) => (
          <path key={index} className="paper-line" d={pathOf(values, at.x, at.y)} />
        ))}
        {outside.map(({ repetition, from, until }) => (
          <path
            key={`${repetition}/${from}`}
            className="paper-outside"
            d={pathOf(
              scaled(curve.repetitions[repetition] ?? []).map((value, phase) =>
                phase >= from && phase < until ? value : null,
              ),
              at.x,
              at.y,
            )}
          />
        ))}
        {joined(outside).map(({ from, until }) => (
          <path
            key={from}
            className="paper-outside-bar"
            d={`M${at.x(from).toFixed(1)} ${BAR - 4}v8m0 -4H${at.x(Math.min(until, 100)).toFixed(1)}m0 -4v8`}
          />
        ))}
        <path className="paper-template" d={pathOf(mean, at.x, at.y)} />
      </>
    );
  };
  return (
    <Picture full={PHASES} label={label}>
      {drawn}
    </Picture>
  );
}

/** One quantity over the gait cycle: left drawn through, right dashed, each with its band. */
export function PaperCycle({
  name,
  left,
  right,
}: {
  name: string;
  left: CycleCurve | undefined;
  right: CycleCurve | undefined;
}) {
  const unit = displayUnit((left ?? right)?.unit ?? '');
  const edge = (curve: CycleCurve | undefined, sign: number) =>
    (curve?.mean ?? []).map((value, index) => (value + sign * (curve?.spread[index] ?? 0)) * unit.factor);
  const line = (curve: CycleCurve | undefined) => edge(curve, 0);
  const range = extent(edge(left, 1), edge(left, -1), edge(right, 1), edge(right, -1)) ?? [0, 1];
  const most = (curve: CycleCurve | undefined) =>
    quantity(curve ? Math.max(...curve.mean) : null, (left ?? right)?.unit ?? '');
  const drawn = (size: Size) => {
    const at = frame(size, range[0], range[1], 0, 100);
    const x = (index: number) => at.x(2 * index);
    return (
      <>
        <Axes
          at={at}
          suffix=""
          xTicks={[0, 25, 50, 75, 100].map((phase) => ({ at: at.x(phase), text: `${phase} %` }))}
        />
        <path className="paper-band paper-band-own" d={bandOf(edge(left, -1), edge(left, 1), x, at.y)} />
        <path className="paper-band" d={bandOf(edge(right, -1), edge(right, 1), x, at.y)} />
        <path className="paper-line paper-line-strong" d={pathOf(line(left), x, at.y)} />
        <path className="paper-template paper-right" d={pathOf(line(right), x, at.y)} />
      </>
    );
  };
  return (
    <Picture full={PHASES} label={t('cycle.summary', { name, left: most(left), right: most(right) })}>
      {drawn}
    </Picture>
  );
}

/** One measure over the sessions, with its spread. */
export function PaperProgress({ measure, sessionId }: { measure: ProgressMeasure; sessionId: string }) {
  const unit = displayUnit(measure.unit);
  const { points } = measure;
  const times = points.map((point) => new Date(point.at).getTime());
  const scaled = (pick: (point: (typeof points)[number]) => number) => points.map((point) => pick(point) * unit.factor);
  const low = scaled((point) => point.low);
  const high = scaled((point) => point.high);
  const values = scaled((point) => point.value);
  const range = extent(low, high, values) ?? [0, 1];
  const label = t('report.progressLabel', {
    label: measure.label,
    count: points.length,
    first: quantity(points[0]?.value, measure.unit),
    last: quantity(points.at(-1)?.value, measure.unit),
  });
  const drawn = (size: Size) => {
    const at = frame(size, range[0], range[1], times[0] ?? 0, times.at(-1) ?? 1);
    const x = (index: number) => at.x(times[index] ?? 0);
    const last = points.length - 1;
    // The first and the last day are named, and those between that leave room for their neighbours.
    const shown = points.reduce<number[]>(
      (named, _, index) =>
        index === 0 || index === last || (x(index) - x(named.at(-1) ?? 0) >= LABEL && x(last) - x(index) >= LABEL)
          ? [...named, index]
          : named,
      [],
    );
    return (
      <>
        <Axes
          at={at}
          suffix={unit.suffix === '°' ? '°' : ''}
          xTicks={shown.map((index) => ({ at: x(index), text: date(points[index]?.at ?? '') }))}
        />
        <path className="paper-band paper-band-own" d={bandOf(low, high, x, at.y)} />
        <path className="paper-line paper-line-strong" d={pathOf(values, x, at.y)} />
        {values.map((value, index) => (
          <circle
            key={points[index]?.session_id}
            className={points[index]?.session_id === sessionId ? 'paper-point paper-point-here' : 'paper-point'}
            cx={x(index)}
            cy={at.y(value)}
            r="3.6"
          />
        ))}
      </>
    );
  };
  return (
    <Picture full={DAYS} label={label}>
      {drawn}
    </Picture>
  );
}
