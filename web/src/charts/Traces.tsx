// Running joint-angle curves of a player, one above the other, each with its uncertainty band.
import { Button } from '@mantine/core';
import { IconPlayerPause, IconPlayerPlay } from '@tabler/icons-react';
import { useEffect, useMemo, useRef, useState, type ReactNode } from 'react';
import type uPlot from 'uplot';
import { t } from '../i18n';
import { channelLabel, zeroOf } from '../lib/channels';
import { displayUnit, number, quantity } from '../lib/format';
import { hasSigma, sigmaOf } from '../kinds/magnetic/magnetic';
import { useSnapshot } from '../player/hooks';
import type { Player } from '../player/types';
import { hatch } from './hatch';
import { axis, Plot, themeColour, type PlotOptions } from './Plot';
import { extent, runs, steadyRange } from './scales';
import './Traces.css';

const INVALID = 1;
const SINGULAR = 128;
/** The sensor has turned in its strap. */
const SLIPPED = 256;
const HEIGHT = 132;
/** An angle known no better than this (one standard deviation) says nothing that a number could state. */
const UNKNOWN_RAD = Math.PI / 12;
/** A value that is older than this is not of now. */
const OF_NOW_S = 1.5;

/** A template's value at a time, in the unit it is shown in; NaN where it says nothing. */
export type TemplateAt = (channel: string, timeS: number) => { mean: number; low: number; high: number } | null;

export interface TracesProps {
  player: Player;
  channels: readonly string[];
  windowS?: number;
  /** Drawn dashed behind the patient's curve, with its tolerance band. */
  templateAt?: TemplateAt;
  onSeek?: (timeS: number) => void;
  /** Beside the pause button of a live view. */
  tools?: ReactNode;
}

interface Reading {
  now: number;
  low: number;
  high: number;
}

interface Chart {
  channel: string;
  plot: uPlot | null;
  value: HTMLElement | null;
  flags: Float32Array;
  reading: Reading | null;
  low: number;
  high: number;
}

function traceOptions(chart: Chart, unit: string, isLive: boolean, onSeek: TracesProps['onSeek']): PlotOptions {
  const shown = displayUnit(unit);
  const step = unit === 'rad' ? 20 : shown.suffix.trim() === 'cm' ? 10 : 0.5;
  return {
    cursor: { show: false },
    legend: { show: false },
    padding: [10, 22, 0, 0],
    scales: {
      x: { time: false, range: (_, low, high) => [low, high] },
      // The curve decides the scale: where the uncertainty is huge its band may leave the picture.
      y: { range: () => steadyRange(chart.low, chart.high, step, 2 * step) },
    },
    axes: [
      axis({
        show: true,
        size: 22,
        space: 70,
        incrs: [1, 2, 5, 10, 15, 30, 60],
        values: (_, ticks) => ticks.map((tick) => (isLive && tick === 0 ? t('traces.now') : `${number(tick)} s`)),
      }),
      axis({
        size: shown.suffix.length > 3 ? 84 : 58,
        space: 34,
        values: (_, ticks) => ticks.map((tick) => `${tick}${shown.suffix}`),
      }),
    ],
    series: [
      {},
      { show: true, stroke: 'transparent', points: { show: false } },
      { show: true, stroke: 'transparent', points: { show: false } },
      { stroke: () => themeColour('--tm-muted'), width: 2, dash: [7, 6], points: { show: false } },
      { stroke: 'transparent', points: { show: false } },
      { stroke: 'transparent', points: { show: false } },
      { stroke: () => themeColour('--tm-accent'), width: 3, points: { show: false } },
    ],
    bands: [
      { series: [2, 1], fill: () => themeColour('--tm-neutral-band') },
      { series: [5, 4], fill: () => themeColour('--tm-accent-band') },
    ],
    hooks: {
      drawClear: [
        (plot) => {
          const time = plot.data[0];
          const isUnsure = (index: number) => !isTrusted(chart.flags[index] ?? 0);
          for (const [from, until] of runs(time.length, isUnsure)) {
            hatch(plot, time[from] ?? 0, time[Math.min(until, time.length - 1)] ?? 0);
          }
        },
      ],
      ready: onSeek
        ? [
            (plot) => {
              plot.over.addEventListener('pointerdown', (event) => onSeek(plot.posToVal(event.offsetX, 'x')));
            },
          ]
        : [],
    },
  };
}

function isTrusted(flags: number): boolean {
  return (flags & (INVALID | SINGULAR | SLIPPED)) === 0;
}

/** Whether a number may stand for the value: not where the angle has no meaning in this posture, or is hardly known. */
export function isMeaningful(flags: number, sigma: number, unit: string): boolean {
  return isTrusted(flags) && !(unit === 'rad' && sigma > UNKNOWN_RAD);
}

const EMPTY_DATA: uPlot.AlignedData = [[], [], [], [], [], [], []];

/** Read the window and draw it; returns what a person would read from the curve. */
function draw(
  chart: Chart,
  player: Player,
  unit: string,
  fromS: number,
  untilS: number,
  cursorS: number,
  zeroS: number,
  templateAt?: TemplateAt,
): void {
  const { plot } = chart;
  if (!plot) return;
  const { channel } = chart;
  const read = player.read(fromS, untilS, [channel, sigmaOf(channel), `${channel}.flags`], 4000);
  const { factor } = displayUnit(unit);
  const [raw, sigma, flags] = read.values;
  const zero = zeroOf(channel);
  const count = read.timeS.length;
  const value = new Float64Array(count);
  const low = new Float64Array(count);
  const high = new Float64Array(count);
  const mean = new Float64Array(count).fill(NaN);
  const bandLow = new Float64Array(count).fill(NaN);
  const bandHigh = new Float64Array(count).fill(NaN);
  let now = NaN;
  for (let index = 0; index < count; index += 1) {
    const lost = ((flags?.[index] ?? 0) & INVALID) !== 0;
    const here = lost ? NaN : ((raw?.[index] ?? NaN) - zero) * factor;
    const spread = 2 * (sigma?.[index] ?? NaN) * factor;
    value[index] = here;
    low[index] = here - spread;
    high[index] = here + spread;
    const at = read.timeS[index] ?? 0;
    if (at <= cursorS && at > cursorS - OF_NOW_S)
      now = isMeaningful(flags?.[index] ?? 0, sigma?.[index] ?? NaN, unit) ? here : NaN;
    const template = templateAt?.(channel, at);
    if (template) {
      mean[index] = template.mean - zero * factor;
      bandLow[index] = template.low - zero * factor;
      bandHigh[index] = template.high - zero * factor;
    }
  }
  chart.flags = flags ?? new Float32Array(0);
  const range = extent(value);
  [chart.low, chart.high] = extent(value, mean) ?? [NaN, NaN];
  chart.reading = range ? { now, low: range[0], high: range[1] } : null;
  // uPlot draws a break at null, not at NaN.
  const breaks = (array: Float64Array): (number | null)[] =>
    Array.from(array, (one) => (Number.isNaN(one) ? null : one));
  plot.batch(() => {
    plot.setData(
      [
        Array.from(read.timeS, (at) => at - zeroS),
        breaks(bandLow),
        breaks(bandHigh),
        breaks(mean),
        breaks(low),
        breaks(high),
        breaks(value),
      ],
      false,
    );
    plot.setScale('x', { min: fromS - zeroS, max: untilS - zeroS });
  });
  if (chart.value) {
    const suffix = displayUnit(unit).suffix;
    // Of a speed the whole number says nothing.
    const text = number(now, unit === 'm/s' ? 1 : 0);
    chart.value.textContent = Number.isFinite(now) ? `${text}${suffix}` : '–';
  }
}

export function Traces({ player, channels, windowS = 10, templateAt, onSeek, tools }: TracesProps) {
  const snapshot = useSnapshot(player);
  const { isLive } = snapshot.capabilities;
  const charts = useRef(new Map<string, Chart>());
  const cursors = useRef(new Map<string, HTMLElement>());
  const described = useMemo(
    () =>
      channels.map((channel) => {
        const chart: Chart = {
          channel,
          plot: null,
          value: null,
          flags: new Float32Array(0),
          reading: null,
          low: NaN,
          high: NaN,
        };
        charts.current.set(channel, chart);
        const label = channelLabel(channel);
        return { channel, chart, label, options: traceOptions(chart, label.unit, isLive, onSeek) };
      }),
    [channels, isLive, onSeek],
  );

  useEffect(() => {
    let frame = 0;
    let drawn = '';
    let lastMs = 0;
    const calm = window.matchMedia('(prefers-reduced-motion: reduce)').matches;
    const step = (ms: number) => {
      frame = requestAnimationFrame(step);
      if (calm && ms - lastMs < 250) return;
      const clock = player.clock();
      // In a replay the window goes with the cursor, and stays inside the recording.
      const latestS = Math.max(clock.startS, clock.endS - windowS);
      const fromS = isLive
        ? clock.timeS - windowS
        : Math.min(latestS, Math.max(clock.startS, clock.timeS - windowS / 2));
      const untilS = fromS + windowS;
      const sign = `${clock.timeS}/${fromS}/${player.getSnapshot().epoch}/${described.map((one) => Number(one.chart.plot !== null)).join('')}`;
      if (sign === drawn) return;
      drawn = sign;
      lastMs = ms;
      for (const { chart, label, channel } of described) {
        // Live time counts back from now, so that the axis stands still.
        const zeroS = isLive ? clock.timeS : clock.startS;
        draw(chart, player, label.unit, fromS, isLive ? untilS + 1e-9 : untilS, clock.timeS, zeroS, templateAt);
        const cursor = cursors.current.get(channel);
        if (cursor && chart.plot)
          cursor.style.left = `${chart.plot.valToPos(clock.timeS - zeroS, 'x') + chart.plot.over.offsetLeft}px`;
      }
    };
    frame = requestAnimationFrame(step);
    return () => cancelAnimationFrame(frame);
  }, [player, described, windowS, isLive, templateAt]);

  return (
    <div className={isLive ? 'traces traces-live' : 'traces'}>
      {isLive && (
        <div className="traces-tools">
          <Button
            variant="default"
            size="sm"
            leftSection={
              snapshot.isPlaying ? <IconPlayerPause size={18} aria-hidden /> : <IconPlayerPlay size={18} aria-hidden />
            }
            onClick={() => (snapshot.isPlaying ? player.pause() : player.play())}
          >
            {snapshot.isPlaying ? t('traces.pause') : t('traces.resume')}
          </Button>
          <span className="muted small">
            {!snapshot.isPlaying ? t('traces.paused') : channels.some(hasSigma) ? t('traces.band') : ''}
          </span>
          {tools && <span className="push">{tools}</span>}
        </div>
      )}
      <div className="trace-list">
        {described.map(({ channel, chart, label, options }) => (
          <div className="trace" key={channel}>
            <div className="trace-name">
              <span className="strong">{label.text}</span>
              <span className="trace-value number" ref={(element) => void (chart.value = element)} />
              {label.zero !== 0 && <span className="muted small trace-zero">{t('traces.neutralZero')}</span>}
            </div>
            <div className="trace-plot">
              <Plot
                options={options}
                data={EMPTY_DATA}
                height={HEIGHT}
                label={t('traces.label', { name: label.text })}
                onReady={(plot) => void (chart.plot = plot)}
              />
              {!isLive && (
                <span
                  className="trace-cursor"
                  aria-hidden
                  ref={(element) => {
                    if (element) cursors.current.set(channel, element);
                  }}
                />
              )}
            </div>
          </div>
        ))}
      </div>
      <p className="muted small">{t('traces.hatched')}</p>
      <TraceTable readings={() => described.map(({ chart, label }) => ({ label, reading: chart.reading }))} />
    </div>
  );
}

type ReadingRow = { label: ReturnType<typeof channelLabel>; reading: Reading | null };

/** The curves in words and numbers; brought up to date once a second while it is open. */
function TraceTable({ readings }: { readings: () => ReadingRow[] }) {
  const [isOpen, setOpen] = useState(false);
  const [rows, setRows] = useState<ReadingRow[]>([]);
  const ask = useRef(readings);
  ask.current = readings;
  useEffect(() => {
    if (!isOpen) return;
    setRows(ask.current());
    const timer = setInterval(() => setRows(ask.current()), 1000);
    return () => clearInterval(timer);
  }, [isOpen]);
  const say = (value: number | undefined, unit: string) =>
    value === undefined ? '–' : quantity(value / displayUnit(unit).factor, unit);
  return (
    <details className="as-table" onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>{t('chart.asTable')}</summary>
      <table className="plain-table">
        <thead>
          <tr>
            <th scope="col">{t('traces.angle')}</th>
            <th scope="col">{t('traces.now')}</th>
            <th scope="col">{t('traces.lowest')}</th>
            <th scope="col">{t('traces.highest')}</th>
          </tr>
        </thead>
        <tbody>
          {rows.map(({ label, reading }) => (
            <tr key={label.text}>
              <th scope="row">
                {label.text}
                {label.convention && <span className="measure-note muted small">{label.convention}</span>}
              </th>
              <td className="number">{say(reading?.now, label.unit)}</td>
              <td className="number">{say(reading?.low, label.unit)}</td>
              <td className="number">{say(reading?.high, label.unit)}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </details>
  );
}
