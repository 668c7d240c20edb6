// One measure over the days: value, its spread, what is said of its change, and the days on which something happened.
import { useMemo, useState } from 'react';
import { Link } from 'react-router';
import type uPlot from 'uplot';
import type { Estimator, ProgressEvent, ProgressMeasure } from '../api/types';
import { t } from '../i18n';
import { clockTime, date, dateTime, displayUnit, number, pair, quantity, tick } from '../lib/format';
import { byDate, daysOf, type Day } from '../lib/assessment/days';
import { trendText } from '../lib/assessment/trend';
import { estimatorTitle } from '../lib/sessions';
import { axis, Plot, themeColour, type PlotOptions } from './Plot';

const seconds = (at: string) => new Date(at).getTime() / 1000;

/** The other side, and published values: across the whole picture, behind everything else. */
function across(plot: uPlot, bands: ProgressMeasure['bands'], factor: number): void {
  const { ctx, bbox } = plot;
  ctx.save();
  for (const band of bands) {
    const top = plot.valToPos(band.high * factor, 'y', true);
    const bottom = plot.valToPos(band.low * factor, 'y', true);
    const height = Math.max(bottom - top, 2);
    ctx.fillStyle = themeColour(band.kind === 'norm' ? '--tm-band-norm' : '--tm-band-other');
    ctx.fillRect(bbox.left, top, bbox.width, height);
    ctx.strokeStyle = themeColour('--tm-muted');
    ctx.setLineDash(band.kind === 'norm' ? [2, 5] : [10, 5]);
    ctx.beginPath();
    for (const y of [top, top + height]) {
      ctx.moveTo(bbox.left, y);
      ctx.lineTo(bbox.left + bbox.width, y);
    }
    ctx.stroke();
  }
  ctx.restore();
}

/** So far from one another numbers above the picture can be read. */
const PIN_PX = 16;

/** A line for each day on which something happened, with its number in the strip above the charts. */
function pins(plot: uPlot, days: readonly ProgressEvent[][]): void {
  const { ctx, bbox } = plot;
  const ratio = window.devicePixelRatio || 1;
  ctx.save();
  ctx.strokeStyle = themeColour('--tm-line-strong');
  ctx.fillStyle = themeColour('--tm-muted');
  ctx.font = `600 ${13 * ratio}px 'Atkinson Hyperlegible Next Variable', sans-serif`;
  ctx.textAlign = 'center';
  ctx.setLineDash([3 * ratio, 4 * ratio]);
  ctx.lineWidth = 1.5 * ratio;
  let named = -Infinity;
  days.forEach((day, index) => {
    const x = plot.valToPos(seconds(day[0]?.at ?? ''), 'x', true);
    if (!(x >= bbox.left && x <= bbox.left + bbox.width)) return;
    ctx.beginPath();
    ctx.moveTo(x, bbox.top + 4 * ratio);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    if (x - named < PIN_PX * ratio) return;
    named = x;
    ctx.fillText(String(index + 1), x, bbox.top - 4 * ratio);
  });
  ctx.restore();
}

/** What happened beside the sessions, day by day, once for all charts of a page. */
export function EventStrip({ events }: { events: readonly ProgressEvent[] }) {
  if (events.length === 0) return null;
  return (
    <section className="event-strip" aria-label={t('progress.events')}>
      <h3>{t('progress.events')}</h3>
      <ol className="small">
        {byDate(events).map((day) => (
          <li key={day[0]?.at}>
            <span className="strong nowrap">{date(day[0]?.at ?? '')}</span>
            <ul className="plain-list">
              {[...new Set(day.map((event) => event.text))].map((text) => (
                <li key={text}>{text}</li>
              ))}
            </ul>
          </li>
        ))}
      </ol>
    </section>
  );
}

/** What each band is, with its source; of the other side how alike the two are. */
export function BandLegend({ bands, unit }: { bands: ProgressMeasure['bands']; unit: string }) {
  if (bands.length === 0) return null;
  return (
    <ul className="band-legend plain-list small muted">
      {bands.map((band) => (
        <li key={band.kind}>
          <span className={`band-key band-key-${band.kind}`} aria-hidden />
          {band.text}: {quantity(band.low, unit)} – {quantity(band.high, unit)}
          {typeof band.symmetry_ratio === 'number' && (
            <>
              {'. '}
              {symmetryText(band.symmetry_ratio, band.symmetry_ratio_sigma ?? 0, band.symmetry_angle_percent ?? null)}
            </>
          )}
        </li>
      ))}
    </ul>
  );
}

/** Less or more than the other side in per cent, when that is more than twice its uncertainty. */
export function symmetryText(ratio: number, sigma: number, angle: number | null): string {
  const of = Math.exp(ratio);
  const [percent, spread] = pair(Math.abs(100 * (of - 1)), 100 * of * sigma, 0);
  const words = {
    percent,
    sigma: spread,
    angle: number(angle, 1),
  };
  if (Math.abs(ratio) <= 2 * sigma) return t('progress.alike', words);
  return t(ratio < 0 ? 'progress.lessThanOther' : 'progress.moreThanOther', words);
}

/** What made a point, in words: the service has name and version in one. */
export function madeBy(point: { orientation: string }, estimators: readonly Estimator[]): string {
  const [orientation = '', version = ''] = point.orientation.split(' ');
  return t('progress.madeBy', { title: estimatorTitle({ orientation }, estimators), version });
}

/** Room of a date under the axis. */
/** Before the first drawing only the whole is as wide as it will be. */
const AXIS_PX = 84;
const DATE_PX = 76;

export function ProgressChart({
  measure,
  events,
  estimators,
  height = 260,
}: {
  measure: ProgressMeasure;
  events: readonly ProgressEvent[];
  estimators: readonly Estimator[];
  height?: number;
}) {
  const unit = displayUnit(measure.unit);
  const { points, bands } = measure;
  const days = useMemo(() => daysOf(points), [points]);
  const [chosen, setChosen] = useState<Day | null>(null);
  const firstS = days[0]?.atS ?? 0;
  const lastS = days.at(-1)?.atS ?? 1;
  const happened = useMemo(() => byDate(events), [events]);
  // What made all of them is said once, what differs in each line.
  const isAlike = points.every((one) => one.orientation === points[0]?.orientation);
  const options = useMemo<PlotOptions>(
    () => ({
      cursor: { show: false },
      legend: { show: false },
      padding: [22, 18, 0, 0],
      scales: {
        x: { time: true, range: [firstS - 43_200, lastS + 43_200] },
        y: {
          range: (_, least, most) => {
            const low = Math.min(least, ...bands.map((band) => band.low * unit.factor));
            const high = Math.max(most, ...bands.map((band) => band.high * unit.factor));
            // A spread of little meaning must not fill the picture.
            const span = unit.suffix === '°' ? 10 : 0;
            const pad = Math.max((high - low) * 0.18, (span - (high - low)) / 2, 1e-3);
            return [low - pad, high + pad];
          },
        },
      },
      axes: [
        axis({
          size: 34,
          space: 80,
          grid: { show: false },
          splits: (chart, __, low, high) => {
            // Whole days only: two labels may not show the same date, nor touch.
            const days = Math.max(1, Math.round((high - low) / 86_400));
            const most = Math.min(6, Math.max(1, Math.floor((chart.width - AXIS_PX) / DATE_PX)));
            const every = Math.max(1, Math.ceil(days / most));
            const start = new Date(low * 1000);
            const first =
              new Date(start.getFullYear(), start.getMonth(), start.getDate() + 1).getTime() / 1000 + 43_200;
            return Array.from(
              { length: Math.ceil(days / every) },
              (___, index) => first + index * every * 86_400,
            ).filter((at) => at <= high);
          },
          values: (_, ticks) => ticks.map((tick) => date(new Date(tick * 1000))),
        }),
        axis({
          size: unit.suffix.length > 2 ? 84 : 60,
          space: 44,
          values: (_, ticks) => ticks.map((at) => tick(at, unit)),
        }),
      ],
      series: [
        {},
        { stroke: 'transparent', points: { show: false } },
        { stroke: 'transparent', points: { show: false } },
        {
          stroke: () => themeColour('--tm-accent'),
          width: 3,
          points: {
            show: true,
            size: 10,
            width: 3,
            stroke: () => themeColour('--tm-accent'),
            fill: () => themeColour('--tm-surface'),
          },
        },
      ],
      bands: [{ series: [2, 1], fill: () => themeColour('--tm-accent-band') }],
      hooks: { drawClear: [(plot) => across(plot, bands, unit.factor), (plot) => pins(plot, happened)] },
    }),
    [unit, happened, bands, firstS, lastS],
  );
  const data = useMemo<uPlot.AlignedData>(
    () => [
      days.map((day) => day.atS),
      days.map((day) => day.low * unit.factor),
      days.map((day) => day.high * unit.factor),
      days.map((day) => day.value * unit.factor),
    ],
    [days, unit.factor],
  );
  return (
    <figure className="figure">
      <Plot
        options={options}
        data={data}
        height={height}
        onReady={(plot) =>
          plot?.over.addEventListener('click', (event) => setChosen(days[plot.posToIdx(event.offsetX)] ?? null))
        }
        label={`${t('trend.summary', { label: measure.label, count: points.length, first: quantity(points[0]?.value, measure.unit), last: quantity(points.at(-1)?.value, measure.unit) })}. ${trendText(measure)}`}
      />
      <BandLegend bands={bands} unit={measure.unit} />
      {chosen && (
        <section className="day-sessions small" aria-live="polite">
          <p className="strong">{t('progress.ofDay', { date: date(new Date(chosen.atS * 1000)) })}</p>
          <ul className="plain-list">
            {chosen.sessions.map((point) => (
              <li key={point.session_id}>
                <Link to={`/sessions/${point.session_id}`}>{clockTime(point.at)}</Link>:{' '}
                {quantity(point.value, measure.unit)}
                {' · '}
                {t('progress.repetitionsOf', { count: point.count })}
              </li>
            ))}
          </ul>
        </section>
      )}
      <details className="as-table">
        <summary>{t('chart.asTable')}</summary>
        <table className="plain-table stacked-table">
          <thead>
            <tr>
              <th scope="col">{t('progress.session')}</th>
              <th scope="col">{measure.label}</th>
              <th scope="col">{t('progress.between')}</th>
              <th scope="col">{t('progress.count')}</th>
              {!isAlike && <th scope="col">{t('progress.estimator')}</th>}
            </tr>
          </thead>
          <tbody>
            {points.map((point) => (
              <tr key={point.session_id}>
                <th scope="row" className="number">
                  <Link to={`/sessions/${point.session_id}`}>{dateTime(point.at)}</Link>
                </th>
                <td className="number" data-label={measure.label}>
                  {quantity(point.value, measure.unit)}
                </td>
                <td className="number" data-label={t('progress.between')}>
                  {quantity(point.low, measure.unit)} – {quantity(point.high, measure.unit)}
                </td>
                <td className="number" data-label={t('progress.count')}>
                  {point.count}
                </td>
                {!isAlike && <td data-label={t('progress.estimator')}>{madeBy(point, estimators)}</td>}
              </tr>
            ))}
          </tbody>
        </table>
        {isAlike && points[0] && (
          <p className="muted small">
            {t('progress.estimator')}: {madeBy(points[0], estimators)}
          </p>
        )}
      </details>
    </figure>
  );
}
