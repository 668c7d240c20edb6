import type { MeasureValue, ProgressMeasure } from '../../api/types';
import { PaperProgress } from '../../charts/ProgressCurve';
import { SideMark } from '../../components/Marks';
import { t } from '../../i18n';
import { isAboutSensors } from '../../lib/events';
import { dateTime, duration, quantity, uncertain, withUnit } from '../../lib/format';
import { mainMeasure } from '../../lib/plain';
import { repetitionsText, reportRows } from '../../lib/assessment/report';
import { trendNotes, trendShort, trendText } from '../../lib/assessment/trend';
import { Sheet, type ReportProps } from './Sheet';
import { sessionTitle } from '../../lib/sessions';
import './report.css';

const pointOf = (measure: ProgressMeasure | null, sessionId: string) =>
  measure?.points.find((one) => one.session_id === sessionId) ?? null;

/** What may be said of the change with this session; the progress beside a report ends with it. */
export function verdict(measure: ProgressMeasure | null, sessionId: string): string {
  // Of too few days the headline says so, once.
  return measure && measure.trend.word !== 'values' && pointOf(measure, sessionId) ? trendShort(measure) : '–';
}

/** The same as sentences. */
export function verdictText(measure: ProgressMeasure): string {
  return [trendText(measure), ...trendNotes(measure)].join(' ');
}

function Headline({
  value,
  measure,
  sessionId,
}: {
  value: MeasureValue | null;
  measure: ProgressMeasure | null;
  sessionId: string;
}) {
  const here = pointOf(measure, sessionId);
  const label = value?.label ?? measure?.label;
  if (!label) return null;
  return (
    <div className="paper-headline">
      <p className="paper-big number">{quantity(value?.value ?? here?.value, value?.unit ?? measure?.unit)}</p>
      <div>
        <p className="strong">{label}</p>
        {typeof value?.template_value === 'number' && (
          <p>{t('report.template', { value: quantity(value.template_value, value.unit) })}</p>
        )}
        {measure && here && <p>{verdictText(measure)}</p>}
      </div>
    </div>
  );
}

/** Sheet 1: what was done, what came of it, whether it changed. */
export function SummarySheet(props: ReportProps) {
  const { session, patient, comparison, progress } = props;
  const measures = progress?.measures ?? [];
  const main = mainMeasure(measures);
  const rows = reportRows(comparison?.summary ?? [], measures, undefined, main?.measure);
  const mainValue = comparison?.summary.find((one) => one.measure === main?.measure) ?? rows[0]?.value ?? null;
  return (
    <Sheet title={t('report.summary')} number={1} session={session} patient={patient}>
      <dl className="paper-facts">
        <div>
          <dt>{t('exercise.one')}</dt>
          <dd>{sessionTitle(session)}</dd>
        </div>
        <div>
          <dt>{t('details.recorded')}</dt>
          <dd>
            {dateTime(session.started_at ?? session.created_at)} · {duration(session.duration_s)}
          </dd>
        </div>
        {patient.affected_side && (
          <div>
            <dt>{t('patient.affectedSide')}</dt>
            <dd>
              <SideMark side={patient.affected_side} />
            </dd>
          </div>
        )}
        {comparison && (
          <div>
            <dt>{t('progress.count')}</dt>
            <dd>{repetitionsText(comparison)}</dd>
          </div>
        )}
      </dl>
      <Headline value={mainValue} measure={main} sessionId={session.id} />
      {session.events.filter(isAboutSensors).map((event) => (
        <p key={`${event.kind} ${event.time_s} ${event.text}`} className="strong">
          {event.text}
        </p>
      ))}
      {comparison && comparison.findings.length > 0 && (
        <>
          <h3>{t('report.findings')}</h3>
          <ul className="paper-findings">
            {comparison.findings.map((finding) => (
              <li key={finding}>{finding}</li>
            ))}
          </ul>
        </>
      )}
      {!comparison && <p>{t('report.notCompared')}</p>}
      {main && main.points.length > 1 && (
        <figure className="paper-figure">
          <figcaption>{t('report.overTime', { label: withUnit(main.label, main.unit) })}</figcaption>
          <PaperProgress measure={main} sessionId={session.id} />
        </figure>
      )}
      {rows.length > 0 && (
        <table className="paper-table">
          <caption>{t('report.tableCaption')}</caption>
          <thead>
            <tr>
              <th scope="col">{t('compare.measure')}</th>
              <th scope="col">{t('report.thisSession')}</th>
              <th scope="col">{t('compare.template')}</th>
              <th scope="col">{t('report.change')}</th>
            </tr>
          </thead>
          <tbody>
            {rows.map(({ value, progress: over }) => (
              <tr key={value.measure}>
                <th scope="row">{value.label}</th>
                <td className="number" data-label={t('report.thisSession')}>
                  <span>
                    {uncertain(value.value ?? null, value.uncertainty ?? null, value.unit)}{' '}
                    <span className="paper-count">{t('report.n', { count: value.count })}</span>
                  </span>
                </td>
                <td className="number" data-label={t('compare.template')}>
                  {quantity(value.template_value, value.unit)}
                </td>
                <td data-label={t('report.change')}>{verdict(over, session.id)}</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
      <p className="paper-note">{t('report.tableHelp')}</p>
    </Sheet>
  );
}
