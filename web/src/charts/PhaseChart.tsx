// One channel over the phases of a movement: the template with its band, every repetition, red where it leaves the band.
import { useEffect, useMemo, useRef } from 'react';
import type uPlot from 'uplot';
import { LegendRow, LegendStroke } from './Legend';
import type { PhaseCurve, PhaseDesign } from '../api/types';
import { t } from '../i18n';
import { displayUnit, quantity, tick } from '../lib/format';
import { aboutZero, bandEdges } from '../lib/assessment/comparison';
import { axis, CHART_FONT, Plot, themeColour, type PlotOptions } from './Plot';
import { extent } from './scales';

export interface PhaseChartProps {
  curve: PhaseCurve;
  /** Positions in `curve.repetitions` that are drawn faint because they are left out. */
  left?: ReadonlySet<number>;
  /** The repetition drawn strongest; null draws all alike. */
  selected?: number | null;
  /** Per repetition, half-open phase intervals outside the band. */
  outside?: readonly (readonly (readonly [number, number])[])[];
  /** A factor on the band while it is being changed, 1 as stored. */
  bandScale?: number;
  onPhase?: (phase: number, repetition: number | null) => void;
  height?: number;
  /** As the therapist named them. */
  phases?: readonly PhaseDesign[];
  /** Phase of the moment that is played, asked for every picture; null where there is none. */
  phaseNow?: () => number | null;
}

const RAD_STEP = 15;

interface Drawn {
  outside: NonNullable<PhaseChartProps['outside']>;
  left: ReadonlySet<number>;
  selected: number | null;
  offset: number;
  onPhase: PhaseChartProps['onPhase'];
  phases: readonly PhaseDesign[];
}

function strokeFor(drawn: { current: Drawn }, repetition: number): string {
  const { left, selected } = drawn.current;
  if (left.has(repetition)) return themeColour('--tm-line-strong');
  return selected === null || selected === repetition ? themeColour('--tm-accent') : themeColour('--tm-accent-band');
}

/** Paint the parts outside the band over the curves, and as a strip along the lower edge. */
function paintOutside(plot: uPlot, drawn: Drawn): void {
  const { ctx, bbox } = plot;
  const ratio = window.devicePixelRatio || 1;
  const phases = plot.data[0];
  ctx.save();
  ctx.strokeStyle = themeColour('--tm-alert');
  ctx.setLineDash([]);
  ctx.lineJoin = 'round';
  ctx.lineCap = 'round';
  drawn.outside.forEach((intervals, repetition) => {
    if (drawn.left.has(repetition)) return;
    if (drawn.selected !== null && drawn.selected !== repetition) return;
    const values = plot.data[drawn.offset + repetition];
    if (!values) return;
    for (const [from, until] of intervals) {
      ctx.lineWidth = (drawn.selected === repetition ? 5 : 3.2) * ratio;
      ctx.beginPath();
      let isDown = false;
      for (let phase = from; phase < Math.min(until, values.length); phase += 1) {
        const value = values[phase];
        if (value === null || value === undefined) {
          isDown = false;
          continue;
        }
        const x = plot.valToPos(phases[phase] ?? phase, 'x', true);
        const y = plot.valToPos(value, 'y', true);
        if (isDown) ctx.lineTo(x, y);
        else ctx.moveTo(x, y);
        isDown = true;
      }
      ctx.stroke();
      const left = plot.valToPos(from, 'x', true);
      const right = plot.valToPos(Math.max(until - 1, from + 0.5), 'x', true);
      ctx.fillStyle = themeColour('--tm-alert');
      ctx.globalAlpha = drawn.selected === repetition ? 0.9 : 0.35;
      ctx.fillRect(left, bbox.top + bbox.height - 5 * ratio, right - left, 5 * ratio);
      ctx.globalAlpha = 1;
    }
  });
  ctx.restore();
}

/** Write the names of the phases above the upper edge, where no curve crosses them, with a dotted line where each begins. */
function paintPhases(plot: uPlot, phases: readonly PhaseDesign[]): void {
  const { ctx, bbox } = plot;
  const ratio = window.devicePixelRatio || 1;
  ctx.save();
  ctx.strokeStyle = ctx.fillStyle = themeColour('--tm-muted');
  ctx.font = CHART_FONT.replace(/^\d+/, String(13 * ratio));
  ctx.textAlign = 'center';
  ctx.lineWidth = ratio;
  ctx.setLineDash([2 * ratio, 4 * ratio]);
  for (const { name, start, end } of phases) {
    const [from, until] = [plot.valToPos(100 * start, 'x', true), plot.valToPos(100 * end, 'x', true)];
    if (start > 0) {
      ctx.beginPath();
      ctx.moveTo(from, bbox.top);
      ctx.lineTo(from, bbox.top + bbox.height);
      ctx.stroke();
    }
    ctx.fillText(name, (from + until) / 2, bbox.top - 7 * ratio, until - from - 6 * ratio);
  }
  ctx.restore();
}

/** The repetition whose curve passes nearest to a point of the plot. */
function nearest(plot: uPlot, phase: number, top: number, drawn: Drawn): number | null {
  const index = Math.max(0, Math.min(100, Math.round(phase)));
  let best: number | null = null;
  let bestDistance = Infinity;
  for (let series = drawn.offset; series < plot.data.length - 1; series += 1) {
    const value = plot.data[series]?.[index];
    if (value === null || value === undefined) continue;
    const distance = Math.abs(plot.valToPos(value, 'y') - top);
    if (distance < bestDistance) {
      bestDistance = distance;
      best = series - drawn.offset;
    }
  }
  return best;
}

const PHASES = Array.from({ length: 101 }, (_, phase) => phase);
const OFFSET = 3;
const NO_PHASES: readonly PhaseDesign[] = [];

export function PhaseChart({
  curve: measured,
  left = new Set(),
  selected = null,
  outside = [],
  bandScale = 1,
  onPhase,
  height = 240,
  phases = NO_PHASES,
  phaseNow,
}: PhaseChartProps) {
  const curve = useMemo(() => aboutZero(measured), [measured]);
  const unit = displayUnit(curve.unit);
  const drawn = useRef<Drawn>({ outside, left, selected, offset: OFFSET, onPhase, phases });
  drawn.current = { outside, left, selected, offset: OFFSET, onPhase, phases };
  const count = curve.repetitions.length;
  const scaled = unit.factor;
  const isClickable = onPhase !== undefined;
  const hasPhases = phases.length > 0;
  // The description follows what is drawn strongest, so a choice redraws the chart.
  const sign = `${selected ?? 'all'}/${[...left].join(',')}`;
  const options = useMemo<PlotOptions>(() => {
    void sign;
    return {
      cursor: { show: isClickable, x: true, y: false, points: { show: false }, drag: { x: false, y: false } },
      legend: { show: false },
      padding: [hasPhases ? 28 : 10, 24, 0, 0],
      scales: {
        x: { time: false, range: [0, 100] },
        y: {
          range: (_, low, high) => {
            const step = scaled > 50 ? RAD_STEP : Math.max((high - low) / 6, 1e-3);
            return [Math.floor(low / step) * step, Math.ceil(high / step) * step];
          },
        },
      },
      axes: [
        axis({ size: 30, space: 60, values: (_, ticks) => ticks.map((tick) => `${tick} %`) }),
        axis({
          size: unit.suffix.length > 2 ? 80 : 56,
          space: 38,
          values: (_, ticks) => ticks.map((at) => tick(at, unit)),
        }),
      ],
      series: [
        {},
        { stroke: 'transparent', points: { show: false } },
        { stroke: 'transparent', points: { show: false } },
        ...Array.from({ length: count }, (_, repetition) => ({
          stroke: () => strokeFor(drawn, repetition),
          width: drawn.current.selected === repetition ? 4 : 2,
          dash: drawn.current.left.has(repetition) ? [3, 5] : undefined,
          points: { show: false },
        })),
        // Last, so that it lies over the repetitions.
        { stroke: () => themeColour('--tm-ink'), width: 2.5, dash: [9, 6], points: { show: false } },
      ],
      bands: [{ series: [2, 1], fill: () => themeColour('--tm-neutral-band') }],
      hooks: {
        draw: [(plot: uPlot) => (paintPhases(plot, drawn.current.phases), paintOutside(plot, drawn.current))],
        ready: isClickable
          ? [
              (plot: uPlot) => {
                plot.over.style.cursor = 'pointer';
                plot.over.addEventListener('click', (event) => {
                  const phase = plot.posToVal(event.offsetX, 'x');
                  drawn.current.onPhase?.(phase, nearest(plot, phase, event.offsetY, drawn.current));
                });
              },
            ]
          : [],
      },
    };
  }, [count, hasPhases, isClickable, scaled, unit, sign]);

  const data = useMemo<uPlot.AlignedData>(() => {
    const show = (values: readonly (number | null)[]) =>
      values.map((value) => (value === null || !Number.isFinite(value) ? null : value * scaled));
    const band = (edge: readonly (number | null)[]) =>
      show(
        edge.map(
          (value, phase) => (curve.mean[phase] ?? NaN) + ((value ?? NaN) - (curve.mean[phase] ?? NaN)) * bandScale,
        ),
      );
    const edges = bandEdges(curve);
    return [
      PHASES,
      band(edges.low),
      band(edges.high),
      ...curve.repetitions.map(show),
      show(curve.mean),
    ] as uPlot.AlignedData;
  }, [curve, bandScale, scaled]);

  const plot = useRef<uPlot | null>(null);
  const head = useRef<HTMLSpanElement>(null);
  useEffect(() => {
    if (!phaseNow) return;
    let frame = 0;
    const step = () => {
      frame = requestAnimationFrame(step);
      const phase = phaseNow();
      const element = head.current;
      if (!element) return;
      element.hidden = phase === null || plot.current === null;
      if (phase !== null && plot.current)
        element.style.left = `${plot.current.valToPos(phase, 'x') + plot.current.over.offsetLeft}px`;
    };
    step();
    return () => cancelAnimationFrame(frame);
  }, [phaseNow]);

  const range = extent(curve.mean);
  const leaves = outside.filter((intervals, repetition) => intervals.length > 0 && !left.has(repetition)).length;
  return (
    <div className="trace-plot">
      <Plot
        options={options}
        data={data}
        height={height}
        onReady={(made) => void (plot.current = made)}
        label={
          t('phase.summary', {
            label: curve.label,
            low: quantity(range?.[0], curve.unit),
            high: quantity(range?.[1], curve.unit),
            count: count - left.size,
          }) + (outside.length ? ` ${t('phase.summaryOutside', { count: leaves })}` : '')
        }
      />
      {phaseNow && <span className="trace-cursor" data-testid="playhead" aria-hidden hidden ref={head} />}
    </div>
  );
}

/** What the strokes mean, in words beside a sample of each. */
export function PhaseLegend({ withOutside, patient }: { withOutside: boolean; patient: boolean }) {
  return (
    <ul className="legend plain-list">
      <LegendRow
        sign={
          <>
            <rect width="34" height="14" rx="3" fill="var(--tm-neutral-band)" />
            <path d="M0 7h34" stroke="var(--tm-ink)" strokeWidth="2.5" strokeDasharray="7 4" />
          </>
        }
      >
        {t('phase.legendTemplate')}
      </LegendRow>
      <LegendStroke stroke="var(--tm-accent)" strokeWidth="2.5">
        {patient ? t('phase.legendPatient') : t('phase.legendRepetition')}
      </LegendStroke>
      {withOutside && (
        <LegendStroke stroke="var(--tm-alert)" strokeWidth="5">
          {t('phase.legendOutside')}
        </LegendStroke>
      )}
    </ul>
  );
}
