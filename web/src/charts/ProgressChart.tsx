// One measure over the days: value, its spread, what is said of its change, and the days on which something happened.
import { useMemo, useState } from 'react';
import { Link } from 'react-router';
import type { Estimator, ProgressEvent, ProgressMeasure } from '../api/types';
import { t } from '../i18n';
import { clockTime, date, dateTime, displayUnit, number, pair, quantity } from '../lib/format';
import { byDate, daysOf, type Day } from '../lib/assessment/days';
import { trendText } from '../lib/assessment/trend';
import { estimatorTitle } from '../lib/sessions';
import { screenMargin } from './ChartFrame';
import { ProgressCurve } from './ProgressCurve';
import './ProgressChart.css';

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
  const { points, bands } = measure;
  const days = useMemo(() => daysOf(points), [points]);
  const happened = useMemo(() => byDate(events), [events]);
  const [chosen, setChosen] = useState<Day | null>(null);
  // What made all of them is said once, what differs in each line.
  const isAlike = points.every((one) => one.orientation === points[0]?.orientation);
  return (
    <figure className="figure">
      <ProgressCurve
        points={days}
        unit={measure.unit}
        bands={bands}
        happened={happened}
        height={height}
        margin={{ ...screenMargin(displayUnit(measure.unit).suffix), top: 22 }}
        onPoint={(index) => setChosen(days[index] ?? null)}
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
