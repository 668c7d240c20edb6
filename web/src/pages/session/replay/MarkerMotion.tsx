// The fused motion of a marker beside its 3D view: place along each axis with what the cameras saw, gaps hatched.
import { Button, Select } from '@mantine/core';
import { useEffect, useMemo, useRef } from 'react';
import type uPlot from 'uplot';
import { LegendRow, LegendStroke } from '../../../charts/Legend';
import { MOTION_BLOCK_S, useMarkerMotion } from '../../../api/queries';
import type { MarkerMotion as Motion, Markers } from '../../../api/types';
import { hatch } from '../../../charts/hatch';
import { axis, Plot, themeColour, type PlotOptions } from '../../../charts/Plot';
import { extent, steadyRange } from '../../../charts/scales';
import { Problem } from '../../../components/Feedback';
import { t } from '../../../i18n';
import { placementLabel } from '../../../lib/channels';
import { number, spreadAlone } from '../../../lib/format';
import { useClockText } from '../../../player/hooks';
import type { Player } from '../../../player/types';

const WINDOW_S = 10;
const HEIGHT = 150;
const GAPS_LISTED = 8;
/** Frames drawn as dots are so far apart at least, so that the line between them is seen. */
const DOT_EVERY_S = 0.1;
const AXES = ['x', 'y', 'z'] as const;

type Gap = { start_s: number; length_s: number };

/** The window goes with the cursor, and stays inside the recording. */
function windowStart(player: Player, timeS: number): number {
  const { startS, endS } = player.clock();
  return Math.min(Math.max(startS, endS - WINDOW_S), Math.max(startS, timeS - WINDOW_S / 2));
}

/** One axis as the chart needs it: time, band, line where seen, line in gaps, frames of the cameras. */
export function tableOf(blocks: readonly Motion[], index: number, zeroS: number): (number | null)[][] {
  const table: (number | null)[][] = [[], [], [], [], [], []];
  let dotS = -Infinity;
  for (const block of blocks) {
    block.time_s.forEach((timeS, row) => {
      const place = block.place_m[index]?.[row] ?? null;
      const spread = 2 * (block.sigma_m[index]?.[row] ?? NaN);
      const isGap = block.is_gap[row] ?? false;
      // Both lines share the tick where a gap begins and ends, so that they meet.
      const atEdge = isGap !== (block.is_gap[row + 1] ?? isGap);
      const frame = block.measured_m[index]?.[row] ?? null;
      const hasDot = frame !== null && timeS - dotS > DOT_EVERY_S - 1e-6;
      if (hasDot) dotS = timeS;
      const known = place !== null && Number.isFinite(spread);
      const row6 = [
        timeS - zeroS,
        known ? place - spread : null,
        known ? place + spread : null,
        isGap && !atEdge ? null : place,
        isGap || atEdge ? place : null,
        hasDot ? frame : null,
      ];
      row6.forEach((value, column) => table[column]?.push(value));
    });
  }
  return table;
}

function optionsOf(
  range: { current: [number, number] },
  gaps: { current: readonly Gap[] },
  zeroS: number,
  onSeek: (sinceStartS: number) => void,
): PlotOptions {
  const hidden = { show: true, stroke: 'transparent', points: { show: false } } as const;
  return {
    cursor: { show: false },
    legend: { show: false },
    padding: [10, 22, 0, 0],
    scales: { x: { time: false, range: (_, low, high) => [low, high] }, y: { range: () => range.current } },
    axes: [
      axis({
        size: 22,
        space: 70,
        incrs: [1, 2, 5, 10],
        values: (_, ticks) => ticks.map((tick) => `${number(tick)} s`),
      }),
      axis({ size: 62, space: 34, values: (_, ticks) => ticks.map((tick) => `${number(tick, 2)} m`) }),
    ],
    series: [
      {},
      hidden,
      hidden,
      { stroke: () => themeColour('--tm-series-2'), width: 3, points: { show: false } },
      { stroke: () => themeColour('--tm-series-6'), width: 3, dash: [9, 5], points: { show: false } },
      {
        stroke: () => themeColour('--tm-series-3'),
        paths: () => null,
        points: {
          show: true,
          size: 6,
          stroke: () => themeColour('--tm-series-3'),
          fill: () => themeColour('--tm-series-3'),
        },
      },
    ],
    bands: [{ series: [2, 1], fill: () => themeColour('--tm-neutral-band') }],
    hooks: {
      drawClear: [
        (plot) => {
          for (const gap of gaps.current) {
            const from = gap.start_s - zeroS;
            if (from + gap.length_s > (plot.scales['x']?.min ?? 0) && from < (plot.scales['x']?.max ?? 0))
              hatch(plot, from, from + gap.length_s);
          }
        },
      ],
      ready: [
        (plot) => void plot.over.addEventListener('pointerdown', (event) => onSeek(plot.posToVal(event.offsetX, 'x'))),
      ],
    },
  };
}

interface AxisProps {
  index: number;
  blocks: readonly Motion[];
  gaps: readonly Gap[];
  player: Player;
  onSeek: (sinceStartS: number) => void;
}

function AxisTrace({ index, blocks, gaps, player, onSeek }: AxisProps) {
  const name = AXES[index] ?? 'x';
  const zeroS = player.clock().startS;
  const range = useRef<[number, number]>([0, 1]);
  const shownGaps = useRef(gaps);
  shownGaps.current = gaps;
  const plot = useRef<uPlot | null>(null);
  const cursor = useRef<HTMLSpanElement>(null);
  const reading = useRef<HTMLSpanElement>(null);
  const table = useMemo(() => tableOf(blocks, index, zeroS), [blocks, index, zeroS]);
  const found = extent(table[3] ?? [], table[4] ?? []);
  range.current = found ? steadyRange(found[0], found[1], 0.1, 0.2) : [0, 1];
  const options = useMemo(() => optionsOf(range, shownGaps, zeroS, onSeek), [zeroS, onSeek]);

  useEffect(() => {
    let frame = 0;
    let drawn = '';
    const times = table[0] ?? [];
    const step = () => {
      frame = requestAnimationFrame(step);
      const { timeS } = player.clock();
      const fromS = windowStart(player, timeS) - zeroS;
      const sign = `${timeS}/${fromS}/${plot.current?.width}`;
      if (sign === drawn || !plot.current) return;
      drawn = sign;
      const shown = plot.current;
      // In a batch the scale holds at once, and so does the place of the cursor.
      shown.batch(() => shown.setScale('x', { min: fromS, max: fromS + WINDOW_S }));
      if (cursor.current) cursor.current.style.left = `${shown.valToPos(timeS - zeroS, 'x') + shown.over.offsetLeft}px`;
      const after = times.findIndex((at) => at !== null && at > timeS - zeroS + 1e-6);
      const row = after < 0 ? times.length - 1 : after - 1;
      const now = table[3]?.[row] ?? table[4]?.[row] ?? null;
      if (reading.current) reading.current.textContent = now === null ? '–' : `${number(now, 2)} m`;
    };
    frame = requestAnimationFrame(step);
    return () => cancelAnimationFrame(frame);
  }, [player, table, zeroS]);

  return (
    <div className="trace">
      <div className="trace-name">
        <span className="strong">{name === 'z' ? t('markers.axisUp') : t('markers.axis', { axis: name })}</span>
        <span className="trace-value number" ref={reading} />
      </div>
      <div className="trace-plot">
        <Plot
          options={options}
          data={table as uPlot.AlignedData}
          height={HEIGHT}
          label={t('markers.trace', { axis: name })}
          onReady={(made) => void (plot.current = made)}
        />
        <span className="trace-cursor" aria-hidden ref={cursor} />
      </div>
    </div>
  );
}

export function MarkerLegend() {
  return (
    <ul className="legend plain-list" aria-label={t('markers.legend')}>
      <LegendRow
        sign={[7, 17, 27].map((x) => (
          <circle key={x} cx={x} cy="7" r="3" fill="var(--tm-series-3)" />
        ))}
      >
        {t('markers.legend.frame')}
      </LegendRow>
      <LegendStroke stroke="var(--tm-series-2)" strokeWidth="3">
        {t('markers.legend.path')}
      </LegendStroke>
      <LegendStroke stroke="var(--tm-series-6)" strokeWidth="3" strokeDasharray="9 5">
        {t('markers.legend.gap')}
      </LegendStroke>
    </ul>
  );
}

export interface MarkerMotionProps {
  /** Fused uploads of the session. */
  fused: readonly Markers[];
  shown: Markers;
  onChoose: (markersId: string) => void;
  player: Player;
  /** Seconds since the start of the recording. */
  onSeek: (sinceStartS: number) => void;
}

export function MarkerMotion({ fused, shown, onChoose, player, onSeek }: MarkerMotionProps) {
  const timeS = useClockText(player, 250);
  const block = Math.floor(windowStart(player, timeS) / MOTION_BLOCK_S);
  const here = useMarkerMotion(shown.session_id, shown.id, block);
  const next = useMarkerMotion(shown.session_id, shown.id, block + 1);
  const blocks = useMemo(() => [here.data, next.data].filter((one) => one !== undefined), [here.data, next.data]);
  const gaps = shown.report?.gaps ?? [];
  const longest = gaps
    .toSorted((a, b) => b.length_s - a.length_s)
    .slice(0, GAPS_LISTED)
    .sort((a, b) => a.start_s - b.start_s);
  const { startS } = player.clock();
  return (
    <>
      <h2 className="visually-hidden">{t('markers.motion')}</h2>
      {fused.length > 1 && (
        <Select
          label={t('markers.which')}
          value={shown.id}
          onChange={(value) => value && onChoose(value)}
          data={fused.map((one) => ({
            value: one.id,
            label: t('markers.of', { marker: one.report?.marker ?? '', segment: placementLabel(one.segment) }),
          }))}
          allowDeselect={false}
        />
      )}
      {here.error && <Problem error={here.error} />}
      <div className="traces">
        <div className="trace-list">
          {AXES.map((name, index) => (
            <AxisTrace key={name} index={index} blocks={blocks} gaps={gaps} player={player} onSeek={onSeek} />
          ))}
        </div>
      </div>
      {longest.length > 0 && (
        <table className="plain-table">
          <caption>{t('markers.gapList')}</caption>
          <thead>
            <tr>
              <th scope="col">{t('markers.gap.start')}</th>
              <th scope="col">{t('markers.gap.length')}</th>
              <th scope="col">{t('markers.gap.sigma')}</th>
            </tr>
          </thead>
          <tbody>
            {longest.map((gap) => (
              <tr key={gap.start_s}>
                <th scope="row">
                  <Button
                    variant="subtle"
                    size="compact-md"
                    aria-label={t('markers.gap.go', { time: `${number(gap.start_s - startS, 1)} s` })}
                    onClick={() => onSeek(Math.max(0, gap.start_s - startS))}
                  >
                    {number(gap.start_s - startS, 1)} s
                  </Button>
                </th>
                <td>{number(gap.length_s, 2)} s</td>
                <td>
                  {spreadAlone(gap.sigma_m * 1000, 1)} mm{gap.withheld ? `, ${t('markers.gap.withheld')}` : ''}
                </td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
      <p className="muted small">{t('markers.lab')}</p>
    </>
  );
}
