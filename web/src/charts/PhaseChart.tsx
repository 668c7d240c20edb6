// One channel over the phases of a movement: the template with its band, every repetition, red where it leaves the band.
import { useEffect, useMemo, useRef, type CSSProperties } from 'react';
import { LegendRow, LegendStroke } from './Legend';
import type { PhaseCurve, PhaseDesign } from '../api/types';
import { t } from '../i18n';
import { displayUnit, plainTick, quantity, tick } from '../lib/format';
import { aboutZero, bandEdges, type OutsideStretch } from '../lib/assessment/comparison';
import { ChartFrame, PERCENT, screenMargin, SHEET, type Place } from './ChartFrame';
import { bandOf, fitted, lineOf, type Values } from './marks';
import { extent } from './scales';
import './PhaseChart.css';

export interface PhaseChartProps {
  curve: PhaseCurve;
  /** Positions in `curve.repetitions` that are left out: drawn faint, and not at all on a sheet. */
  left?: ReadonlySet<number>;
  /** The repetition drawn strongest; null draws all alike. */
  selected?: number | null;
  /** Where repetitions leave the band. */
  outside?: readonly OutsideStretch[];
  /** A factor on the band while it is being changed, 1 as stored. */
  bandScale?: number;
  onPhase?: (phase: number, repetition: number | null) => void;
  height?: number;
  /** As the therapist named them. */
  phases?: readonly PhaseDesign[];
  /** Phase of the moment that is played, asked for every picture; null where there is none. */
  phaseNow?: () => number | null;
  /** Of a sheet for paper. */
  isOnPaper?: boolean;
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

/** The names of the phases above the plot, where no curve crosses them, with a dotted line where each begins. */
function Phases({ phases, at }: { phases: readonly PhaseDesign[]; at: Place }) {
  return phases.map(({ name, start, end }) => (
    <g key={start} className="chart-phase">
      {start > 0 && <path d={`M${at.x(100 * start)} ${at.top}V${at.bottom}`} />}
      <text x={at.x(50 * (start + end))} y={at.top - 3} textAnchor="middle">
        {fitted(name, at.x(100 * end) - at.x(100 * start))}
      </text>
    </g>
  ));
}

/** The repetition whose curve passes nearest to a height at a phase. */
function nearest(repetitions: readonly Values[], phase: number, y: number, at: Place): number | null {
  const index = Math.max(0, Math.min(100, Math.round(phase)));
  const away = repetitions.map((values) => Math.abs(at.y(values[index] ?? NaN) - y));
  const least = Math.min(...away.filter(Number.isFinite));
  return Number.isFinite(least) ? away.indexOf(least) : null;
}

/** All that is drawn of a curve, in the unit that is shown. */
function shownOf(measured: PhaseCurve, bandScale: number) {
  const curve = aboutZero(measured);
  const unit = displayUnit(curve.unit);
  const scaled = (values: Values) =>
    values.map((value) => (typeof value === 'number' && Number.isFinite(value) ? value * unit.factor : null));
  const mean = scaled(curve.mean);
  const edges = bandEdges(curve);
  const edge = (values: Values) =>
    scaled(values).map((value, phase) => {
      const middle = mean[phase] ?? null;
      return value === null || middle === null ? null : middle + (value - middle) * bandScale;
    });
  return { mean, low: edge(edges.low), high: edge(edges.high), repetitions: curve.repetitions.map(scaled) };
}

/** The line that says which moment is played, moved without drawing anything else. */
function usePlayhead(phaseNow: PhaseChartProps['phaseNow']) {
  const head = useRef<HTMLSpanElement>(null);
  useEffect(() => {
    if (!phaseNow) return;
    let frame = 0;
    const step = () => {
      frame = requestAnimationFrame(step);
      const phase = phaseNow();
      if (!head.current) return;
      head.current.hidden = phase === null;
      if (phase !== null) head.current.style.setProperty('--phase', String(phase / 100));
    };
    step();
    return () => cancelAnimationFrame(frame);
  }, [phaseNow]);
  return head;
}

const NO_STRETCHES: readonly OutsideStretch[] = [];
const NONE_LEFT: ReadonlySet<number> = new Set();

export function PhaseChart({
  curve,
  left = NONE_LEFT,
  selected = null,
  outside = NO_STRETCHES,
  bandScale = 1,
  onPhase,
  height = 240,
  phases = [],
  phaseNow,
  isOnPaper = false,
}: PhaseChartProps) {
  const unit = displayUnit(curve.unit);
  const shown = useMemo(() => shownOf(curve, bandScale), [curve, bandScale]);
  const { mean, low, high, repetitions } = shown;
  const drawn = repetitions.flatMap((values, index) => (isOnPaper && left.has(index) ? [] : [{ values, index }]));
  const range = extent(low, high, mean, ...drawn.map((one) => one.values)) ?? [0, 1];
  const named = { ...screenMargin(unit.suffix), top: phases.length > 0 ? 28 : 10 };
  const size = isOnPaper ? SHEET : { height, margin: named };
  const head = usePlayhead(phaseNow);
  const strokeOf = (index: number) =>
    left.has(index) ? 'chart-left' : selected === null ? '' : selected === index ? 'chart-chosen' : 'chart-others';
  const leaving = outside.filter((one) => selected === null || one.repetition === selected);
  const frame = (
    <ChartFrame
      {...size}
      label={labelOf(curve, shown, left, outside, isOnPaper)}
      x={{ ...PERCENT, hasLines: !isOnPaper }}
      y={{
        domain: range,
        isRound: true,
        every: isOnPaper ? 42 : 38,
        text: (at) => (isOnPaper ? plainTick(at, 3) + (unit.suffix === '°' ? '°' : '') : tick(at, unit)),
      }}
      onPoint={
        onPhase &&
        ((x, y, at) => {
          const phase = at.x.invert(x);
          onPhase(phase, nearest(repetitions, phase, y, at));
        })
      }
    >
      {(at) => (
        <>
          <path className="chart-band" d={bandOf(low, high, at.x, at.y)} />
          <Phases phases={phases} at={at} />
          {drawn.map(({ values, index }) => (
            <path key={index} className={`chart-line ${strokeOf(index)}`} d={lineOf(values, at.x, at.y)} />
          ))}
          {leaving.map(({ repetition, from, until }) => (
            <path
              key={`${repetition}/${from}`}
              className="chart-outside"
              d={lineOf(repetitions[repetition]?.slice(from, until) ?? [], (index) => at.x(from + index), at.y)}
            />
          ))}
          {joined(leaving).map(({ from, until }) => (
            <path
              key={from}
              className="chart-outside-bar"
              d={`M${at.x(from)} ${at.bottom + 1}v8m0 -4H${at.x(Math.min(until, 100))}m0 -4v8`}
            />
          ))}
          <path className="chart-template" d={lineOf(mean, at.x, at.y)} />
        </>
      )}
    </ChartFrame>
  );
  if (isOnPaper) return frame;
  return (
    <div className="phase-plot" style={{ '--left': `${named.left}px`, '--right': `${named.right}px` } as CSSProperties}>
      {frame}
      {phaseNow && <span className="phase-playhead" data-testid="playhead" aria-hidden hidden ref={head} />}
    </div>
  );
}

function labelOf(
  curve: PhaseCurve,
  { mean, repetitions }: ReturnType<typeof shownOf>,
  left: ReadonlySet<number>,
  outside: readonly OutsideStretch[],
  isOnPaper: boolean,
): string {
  const { factor } = displayUnit(curve.unit);
  const counted = repetitions.filter((_, index) => !left.has(index));
  const range = isOnPaper ? extent(...counted) : extent(mean);
  const [low, high] = [0, 1].map((end) => quantity(range ? (range[end] ?? NaN) / factor : null, curve.unit));
  const words = { label: curve.label, low: low ?? '', high: high ?? '', count: counted.length };
  if (isOnPaper) return t('report.phaseLabel', words);
  const leaves = new Set(outside.map((one) => one.repetition)).size;
  return t('phase.summary', words) + (outside.length ? ` ${t('phase.summaryOutside', { count: leaves })}` : '');
}

/** What the strokes mean, in words beside a sample of each. */
export function PhaseLegend({ withOutside, patient }: { withOutside: boolean; patient: boolean }) {
  return (
    <ul className="legend plain-list">
      <LegendRow
        sign={
          <>
            <rect className="chart-band" width="34" height="14" rx="3" />
            <path className="chart-template" d="M0 7h34" />
          </>
        }
      >
        {t('phase.legendTemplate')}
      </LegendRow>
      <LegendStroke className="chart-line">
        {patient ? t('phase.legendPatient') : t('phase.legendRepetition')}
      </LegendStroke>
      {withOutside && <LegendStroke className="chart-outside">{t('phase.legendOutside')}</LegendStroke>}
    </ul>
  );
}
