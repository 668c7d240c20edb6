// The report of a walk: what came of it and whether it changed, curves over the gait cycle, method and quality.
import { useComparison, useComparisons, useEstimators, useGait, useProgress } from '../../../api/queries';
import type {
  ComparisonDetail,
  CycleCurve,
  Gait,
  Patient,
  ProgressMeasure,
  SessionDetail,
  WalkMeasure,
} from '../../../api/types';
import { CycleChart, CycleLegend } from '../../../charts/CycleChart';
import { PaperProgress } from '../../../charts/ProgressCurve';
import { QueryBoundary } from '../../../components/Feedback';
import { SideMark } from '../../../components/Marks';
import { t } from '../../../i18n';
import { placementLabel } from '../../../lib/channels';
import { dateTime, number, quantity, withUnit } from '../../../lib/format';
import { estimatorTitle } from '../../../lib/sessions';
import { findMeasure, footOf, measureLabel, measureNames, measureText, strideCount } from '../gait';
import { CurvesSheet } from '../../../pages/report/CurvesSheet';
import { Papers } from '../../../pages/report/Papers';
import { Sheet } from '../../../pages/report/Sheet';
import { verdict, verdictText } from '../../../pages/report/SummarySheet';

interface Walked {
  session: SessionDetail;
  patient: Patient;
  gait: Gait;
}

const SIDES = ['left', 'right'] as const;
const shown = (one: WalkMeasure | undefined) => (one ? measureText(one.value, one.unit, one.sigma) : '–');
const overTime = (measures: readonly ProgressMeasure[], name: string) =>
  measures.find((one) => one.measure === `walk:${name}`) ?? null;

/** The measure that tells most of this walk: the test's result, else speed. */
export function mainOf(measures: readonly ProgressMeasure[]): ProgressMeasure | null {
  return measures.find((one) => one.points.length > 0) ?? null;
}

function Summary({
  session,
  patient,
  gait,
  measures,
  comparison,
}: Walked & { measures: readonly ProgressMeasure[]; comparison: ComparisonDetail | null }) {
  const main = mainOf(measures);
  const here = main?.points.find((one) => one.session_id === session.id) ?? main?.points.at(-1) ?? null;
  const test = gait.test ?? null;
  const counted = findMeasure(gait.feet[0]?.measures, 'stride_length')?.count ?? 0;
  const reasons = [...(test?.reasons ?? []), ...gait.reasons];
  const both = [...gait.both, ...(gait.balance?.measures ?? [])];
  // Of one of the first walks no row has a change: what stands above says so once.
  const hasChanges = measures.some((one) => one.trend.word !== 'values');
  return (
    <Sheet title={t('walkReport.title')} number={1} session={session} patient={patient}>
      <dl className="paper-facts">
        <div>
          <dt>{t('exercise.one')}</dt>
          <dd>{session.exercise_name ?? (test ? t(`walk.kind.${test.kind}`) : t('session.free'))}</dd>
        </div>
        <div>
          <dt>{t('details.recorded')}</dt>
          <dd>{dateTime(session.started_at ?? session.created_at)}</dd>
        </div>
        {patient.affected_side && (
          <div>
            <dt>{t('patient.affectedSide')}</dt>
            <dd>
              <SideMark side={patient.affected_side} />
            </dd>
          </div>
        )}
        {test && (
          <div>
            <dt>{t('walkReport.wholeWalk', { name: t(`walk.kind.${test.kind}`) })}</dt>
            <dd className="number">
              {number(test.distance_m, test.distance_m < 100 ? 2 : 0)} m · {number(test.time_s, 1)} s ·{' '}
              {number(test.speed_mps, 2)} m/s
            </dd>
          </div>
        )}
        <div>
          <dt>{t('progress.count')}</dt>
          <dd>{t('walkReport.strides', { count: counted })}</dd>
        </div>
      </dl>
      {main && (
        <div className="paper-headline">
          <p className="paper-big number">{quantity(here?.value, main.unit)}</p>
          <div>
            <p className="strong">{main.label}</p>
            <p>{verdictText(main)}</p>
          </div>
        </div>
      )}
      {main && main.points.length > 1 && (
        <figure className="paper-figure">
          <figcaption>{t('report.overTime', { label: withUnit(main.label, main.unit) })}</figcaption>
          <PaperProgress measure={main} sessionId={session.id} />
        </figure>
      )}
      <table className="paper-table">
        <caption>{t('walkReport.table')}</caption>
        <thead>
          <tr>
            <th scope="col">{t('numbers.measure')}</th>
            {SIDES.map((side) => (
              <th scope="col" key={side}>
                {t(`numbers.${side}`)}
              </th>
            ))}
            <th scope="col">{t('numbers.difference')}</th>
            {hasChanges && <th scope="col">{t('walkReport.change')}</th>}
          </tr>
        </thead>
        <tbody>
          {measureNames(gait, false).map((name) => (
            <tr key={name}>
              <th scope="row">{measureLabel(name)}</th>
              {SIDES.map((side) => (
                <td className="number" key={side} data-label={t(`numbers.${side}`)}>
                  {shown(findMeasure(footOf(gait, side)?.measures, name))}
                </td>
              ))}
              <td className="number" data-label={t('numbers.difference')}>
                {shown(findMeasure(gait.asymmetry, name))}
              </td>
              {hasChanges && (
                <td data-label={t('walkReport.change')}>
                  {/* Both feet walk at one speed. */}
                  {overTime(measures, name)
                    ? verdict(overTime(measures, name), session.id)
                    : SIDES.flatMap((side) => {
                        const over = overTime(measures, `${name}:${side}`);
                        return over ? [`${t(`numbers.${side}`)}: ${verdict(over, session.id)}`] : [];
                      }).join('; ') || '–'}
                </td>
              )}
            </tr>
          ))}
        </tbody>
      </table>
      {both.length > 0 && (
        <table className="paper-table">
          <caption>{t('walkReport.both')}</caption>
          <thead>
            <tr>
              <th scope="col">{t('numbers.measure')}</th>
              <th scope="col">{t('walkReport.value')}</th>
              {hasChanges && <th scope="col">{t('walkReport.change')}</th>}
            </tr>
          </thead>
          <tbody>
            {both.map((one) => (
              <tr key={one.measure}>
                <th scope="row">{measureLabel(one.measure)}</th>
                <td className="number" data-label={t('walkReport.value')}>
                  {shown(one)}
                </td>
                {hasChanges && (
                  <td data-label={t('walkReport.change')}>{verdict(overTime(measures, one.measure), session.id)}</td>
                )}
              </tr>
            ))}
          </tbody>
        </table>
      )}
      <p className="paper-note">{t('walkReport.help')}</p>
      {comparison && (
        <>
          <h3>{t('compare.withStrides', { name: comparison.template_name, count: comparison.repetition_count })}</h3>
          <ul className="paper-findings">
            {comparison.findings.map((finding) => (
              <li key={finding}>{finding}</li>
            ))}
          </ul>
        </>
      )}
      {reasons.length > 0 && (
        <>
          <h3>{t('walkReport.doubts')}</h3>
          <ul className="paper-findings paper-small">
            {reasons.map((reason) => (
              <li key={reason}>{reason}</li>
            ))}
          </ul>
        </>
      )}
    </Sheet>
  );
}

function Curves({ session, patient, gait, names }: Walked & { names: readonly CycleCurve['name'][] }) {
  const of = (side: 'left' | 'right', name: CycleCurve['name']) =>
    footOf(gait, side)?.curves.find((one) => one.name === name);
  return (
    <Sheet title={t('walkReport.curves')} number={2} session={session} patient={patient}>
      <CycleLegend className="paper-legend" />
      <div className="paper-curves">
        {names.map((name) => (
          <figure key={name} className="paper-figure">
            <figcaption>{withUnit(t(`cycle.${name}`), (of('left', name) ?? of('right', name))?.unit)}</figcaption>
            <CycleChart isOnPaper name={t(`cycle.${name}`)} left={of('left', name)} right={of('right', name)} />
          </figure>
        ))}
      </div>
      <p className="paper-note">{t('cycle.help')}</p>
    </Sheet>
  );
}

function Method({ session, patient, gait, page }: Walked & { page: number }) {
  const estimators = useEstimators();
  const { balance, result } = gait;
  const all = session.packets_stored + session.packets_missing;
  const counted = gait.feet.reduce(
    (sum, foot) => sum + (foot.counted_count || foot.strides.filter((one) => one.is_counted).length),
    0,
  );
  const count = (kind: string) => session.events.filter((event) => event.kind === kind).length;
  const title = estimatorTitle(result, estimators.data ?? []);
  const apart = balance
    ? t(`walkReport.apart.${balance.apart_source}`, { apart: quantity(balance.apart_m, 'm') })
    : t(gait.has_step_width ? 'walkReport.apart.known' : 'walkReport.apart.unknown');
  const lines: [string, string][] = [
    [t('walkReport.sensors'), `${session.placements.map(placementLabel).join(', ')}; ${number(session.rate_hz)} Hz`],
    [
      t('walkReport.forces'),
      balance ? t('walkReport.forcesYes', { mass: number(balance.mass_kg, 1) }) : t('walkReport.forcesNo'),
    ],
    [t('walkReport.apart'), apart],
    [
      t('report.estimator'),
      t('walkReport.estimator', {
        title,
        version: result.orientation_version,
        pipeline: result.pipeline_version,
        kind: result.kind === 'live' ? t('result.live') : t('result.offline'),
      }),
    ],
    [
      t('walkReport.lost'),
      all > 0
        ? t('walkReport.lostText', {
            percent: number((100 * session.packets_missing) / all, 1),
            gaps: count('gap'),
            forces: count('forces_lost'),
          })
        : t('details.uploaded'),
    ],
    [t('walkReport.counted'), t('walkReport.countedText', { counted, all: strideCount(gait) })],
  ];
  return (
    <Sheet title={t('report.method')} number={page} session={session} patient={patient}>
      <dl className="paper-method">
        {lines.map(([name, value]) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd>{value}</dd>
          </div>
        ))}
      </dl>
      <h3>{t('report.meaning')}</h3>
      <dl className="paper-method">
        {(['error', 'difference', 'cycle', 'margin'] as const).map((word) => (
          <div key={word}>
            <dt>{t(`walkReport.word.${word}`)}</dt>
            <dd>{t(`walkReport.word.${word}.text`)}</dd>
          </div>
        ))}
      </dl>
      <p className="paper-note">{t('report.limits')}</p>
      <p className="paper-note paper-ids">{t('report.ids', { session: session.id, result: result.id })}</p>
    </Sheet>
  );
}

export function WalkSheets({ session, patient }: { session: SessionDetail; patient: Patient }) {
  const gait = useGait(session.id);
  const progress = useProgress(patient.id, session.exercise_id ?? null, session.id);
  const comparisons = useComparisons(session.id);
  const of =
    (comparisons.data ?? []).find((one) => one.result_id === session.main_result_id) ?? comparisons.data?.[0] ?? null;
  const found = useComparison(of?.id ?? null);
  const comparison = found.data ?? null;
  const hasStrides = comparison !== null && comparison.repetitions.length > 0;
  return (
    <QueryBoundary of={gait} lines={8} height={40}>
      {(walk) => {
        const names = [...new Set(walk.feet.flatMap((foot) => foot.curves.map((curve) => curve.name)))];
        return (
          <Papers>
            <Summary
              session={session}
              patient={patient}
              gait={walk}
              measures={(progress.data?.measures ?? []).filter((one) => one.measure.startsWith('walk:'))}
              comparison={comparison}
            />
            {names.length > 0 && <Curves session={session} patient={patient} gait={walk} names={names} />}
            {hasStrides && (
              <CurvesSheet
                session={session}
                patient={patient}
                comparison={comparison}
                page={names.length > 0 ? 3 : 2}
              />
            )}
            <Method
              session={session}
              patient={patient}
              gait={walk}
              page={2 + Number(names.length > 0) + Number(hasStrides)}
            />
          </Papers>
        );
      }}
    </QueryBoundary>
  );
}
