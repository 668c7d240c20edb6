// One measure over the sessions: value, its spread, what happened meanwhile, and whether the change is real.
import { useMemo } from 'react';
import type uPlot from 'uplot';
import type { Estimator, ProgressEvent, ProgressMeasure } from '../api/types';
import { t } from '../i18n';
import { date, dateTime, difference, displayUnit, number, pair, quantity, span, tick } from '../lib/format';
import { BASELINE } from '../lib/assessment/baseline';
import { estimatorTitle } from '../lib/sessions';
import { axis, Plot, themeColour, type PlotOptions } from './Plot';

const seconds = (at: string) => new Date(at).getTime() / 1000;

/** The verdict on a change: only called a change when it is larger than two sessions differ by chance. */
export function changeText({
  change,
  is_real_change: isReal,
  unit,
  limit,
  baseline,
}: {
  change?: number | null;
  is_real_change?: boolean | null;
  unit: string;
  limit: number | null | undefined;
  /** Baseline sessions that there are; fewer than three are too few. */
  baseline?: number;
}): string {
  if (baseline !== undefined && baseline < BASELINE)
    return t('progress.fewBaseline', { count: baseline, of: BASELINE });
  if (change === null || change === undefined || isReal === null || isReal === undefined) return t('progress.tooFew');
  const words = { change: difference(change, unit), limit: span(limit, unit) };
  return isReal ? t('progress.changeReal', words) : t('progress.changeNotReal', words);
}

/** The same of the newest session of a measure, whose value stands beside it, as its report has it. */
export function verdictOf({ points, unit, minimal_detectable_change, baseline_sessions }: ProgressMeasure): string {
  const { change, is_real_change } = points.at(-1) ?? {};
  return changeText({ change, is_real_change, unit, limit: minimal_detectable_change, baseline: baseline_sessions });
}

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

function pins(plot: uPlot, events: readonly ProgressEvent[]): void {
  const { ctx, bbox } = plot;
  const ratio = window.devicePixelRatio || 1;
  ctx.save();
  ctx.strokeStyle = themeColour('--tm-line-strong');
  ctx.fillStyle = themeColour('--tm-muted');
  ctx.font = `600 ${13 * ratio}px 'Atkinson Hyperlegible Next Variable', sans-serif`;
  ctx.textAlign = 'center';
  ctx.setLineDash([3 * ratio, 4 * ratio]);
  ctx.lineWidth = 1.5 * ratio;
  events.forEach((event, index) => {
    const x = plot.valToPos(seconds(event.at), 'x', true);
    if (x < bbox.left || x > bbox.left + bbox.width) return;
    ctx.beginPath();
    ctx.moveTo(x, bbox.top + 4 * ratio);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    ctx.fillText(String(index + 1), x, bbox.top - 4 * ratio);
  });
  ctx.restore();
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
  const firstS = points[0] ? seconds(points[0].at) : 0;
  const lastS = points.at(-1) ? seconds(points.at(-1)?.at ?? '') : 1;
  const within = useMemo(
    () => events.filter((event) => seconds(event.at) >= firstS - 43_200 && seconds(event.at) <= lastS + 43_200),
    [events, firstS, lastS],
  );
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
      hooks: { drawClear: [(plot) => across(plot, bands, unit.factor), (plot) => pins(plot, within)] },
    }),
    [unit, within, bands, firstS, lastS],
  );
  const data = useMemo<uPlot.AlignedData>(
    () => [
      points.map((point) => seconds(point.at)),
      points.map((point) => point.low * unit.factor),
      points.map((point) => point.high * unit.factor),
      points.map((point) => point.value * unit.factor),
    ],
    [points, unit.factor],
  );
  return (
    <figure className="figure">
      <Plot
        options={options}
        data={data}
        height={height}
        label={`${t('trend.summary', { label: measure.label, count: points.length, first: quantity(points[0]?.value, measure.unit), last: quantity(points.at(-1)?.value, measure.unit) })}. ${verdictOf(measure)}`}
      />
      <BandLegend bands={bands} unit={measure.unit} />
      {within.length > 0 && (
        <ol className="pins small muted">
          {within.map((event) => (
            <li key={`${event.at}${event.text}`}>
              {event.text} <span className="nowrap">({date(event.at)})</span>
            </li>
          ))}
        </ol>
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
                  {dateTime(point.at)}
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
