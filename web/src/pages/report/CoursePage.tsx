// The report of a course of therapy: what was done and what changed, the therapist's words, and the first beside the newest session.
import { Button } from '@mantine/core';
import { IconPrinter } from '@tabler/icons-react';
import { useParams, useSearchParams } from 'react-router';
import { useComparison, useCourse, usePatient, useProgress } from '../../api/queries';
import type { ComparisonDetail, Course, Patient, Progress, ProgressMeasure } from '../../api/types';
import { PhaseChart } from '../../charts/PhaseChart';
import { PaperProgress } from '../../charts/ProgressCurve';
import { QueryBoundary, Empty } from '../../components/Feedback';
import { Page } from '../../components/Page';
import { WeightedSum } from '../../components/WeightedSum';
import { t } from '../../i18n';
import { isOfStrides, outsideOf, pickCurves, primaryChannel } from '../../lib/assessment/comparison';
import { courseRows } from '../../lib/assessment/course';
import { isSure, shownChange, trendNotes, trendShort, trendText } from '../../lib/assessment/trend';
import { activeText } from '../../lib/assessment/practice';
import { date, number, quantity, withUnit } from '../../lib/format';
import { fullName, patientCrumbs } from '../../lib/people';
import { CourseWords } from './CourseWords';
import { PhaseLegend } from './PhaseLegend';
import { Papers } from './Papers';
import { Sheet } from './Sheet';
import './report.css';

const EPOCH = new Date(0);

interface CourseProps {
  patient: Patient;
  course: Course;
  progress: Progress;
}

/** Levels and change; what is no level yet is the newest value alone. */
function Rows({ rows, caption }: { rows: ProgressMeasure[]; caption: string }) {
  const cells = ['course.baseline', 'course.now', 'course.change', 'course.n'] as const;
  return (
    <table className="paper-table">
      <caption>{caption}</caption>
      <thead>
        <tr>
          <th scope="col">{t('compare.measure')}</th>
          {cells.map((cell) => (
            <th scope="col" key={cell}>
              {t(cell)}
            </th>
          ))}
        </tr>
      </thead>
      <tbody>
        {rows.map((measure) => {
          const levels = shownChange(measure.trend, measure.unit);
          return (
            <tr key={measure.measure}>
              <th scope="row">{measure.label}</th>
              <td className="number" data-label={t('course.baseline')}>
                {levels ? quantity(levels.start, measure.unit) : '–'}
              </td>
              <td className="number" data-label={t('course.now')}>
                {levels
                  ? quantity(levels.now, measure.unit)
                  : t('course.valueOnly', { value: quantity(measure.points.at(-1)?.value, measure.unit) })}
              </td>
              <td className={isSure(measure) ? 'strong' : ''} data-label={t('course.change')}>
                {trendShort(measure)}
              </td>
              <td className="number" data-label={t('course.n')}>
                {number(measure.trend.days)}
              </td>
            </tr>
          );
        })}
      </tbody>
    </table>
  );
}

function Summary({ patient, course, progress }: CourseProps) {
  const rows = courseRows(progress.measures);
  const main = rows[0];
  const facts: [string, string][] = [
    [t('exercise.one'), course.exercise_name],
    ...(course.first_at && course.last_at
      ? [
          [
            t('course.period'),
            t('course.periodText', { first: date(course.first_at, EPOCH), last: date(course.last_at, EPOCH) }),
          ] as [string, string],
        ]
      : []),
    [
      t('course.done'),
      // A walk has strides, and no repetitions that count.
      t(main?.measure.startsWith('walk:') ? 'course.doneWalks' : 'course.doneText', {
        count: course.session_count,
        repetitions: number(course.valid_repetitions),
        active: activeText(course.active_s),
      }),
    ],
    ...(typeof course.adherence_percent === 'number'
      ? [
          [
            t('course.adherence'),
            [
              `${number(course.adherence_percent)} %`,
              (course.pain_stops ?? 0) > 0 && t('practice.pain', { count: course.pain_stops ?? 0 }),
            ]
              .filter(Boolean)
              .join(', '),
          ] as [string, string],
        ]
      : []),
    ...(course.prescribed.length > 0
      ? [[t('course.prescribed'), course.prescribed.join('; ')] as [string, string]]
      : []),
  ];
  return (
    <Sheet title={t('course.title')} number={1} patient={patient} version={course.service_version}>
      <dl className="paper-facts">
        {facts.map(([name, value]) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd>{value}</dd>
          </div>
        ))}
      </dl>
      <CourseWords patient={patient} course={course} />
      {main && main.points.length > 1 && (
        <figure className="paper-figure">
          <figcaption>
            {withUnit(main.label, main.unit)}: {trendText(main)}
          </figcaption>
          <PaperProgress measure={main} sessionId={main.points.at(-1)?.session_id ?? ''} />
          {trendNotes(main).map((note) => (
            <p key={note} className="paper-note">
              {note}
            </p>
          ))}
          {main.bands.map((band) => (
            <p key={band.kind} className="paper-note">
              {t('course.beside')}: {band.text}: {quantity(band.low, main.unit)} – {quantity(band.high, main.unit)}
            </p>
          ))}
        </figure>
      )}
      {rows.length > 0 ? <Rows rows={rows} caption={t('course.table')} /> : <p>{t('progress.emptyText')}</p>}
      <p className="paper-note">{t('course.tableHelp')}</p>
      {progress.events.length > 0 && (
        <>
          <h3>{t('progress.events')}</h3>
          <ul className="paper-findings paper-small">
            {progress.events.map((event) => (
              <li key={`${event.at}${event.text}`}>
                {date(event.at, EPOCH)}: {event.text}
              </li>
            ))}
          </ul>
        </>
      )}
    </Sheet>
  );
}

/** So many curves of each end, and one fewer where its sum stands below, fill the sheet. */
const MOST_CURVES = 3;

function Ends({ comparison, title, curves: most }: { comparison: ComparisonDetail; title: string; curves: number }) {
  const left = new Set(comparison.repetitions.flatMap((one, index) => (one.repetition.is_kept ? [] : [index])));
  const curves = pickCurves(comparison.curves, false, primaryChannel(comparison.summary)).slice(0, most);
  return (
    <div className="paper-end">
      <h3>
        {title} <span className="paper-count">{t('report.n', { count: comparison.repetition_count })}</span>
      </h3>
      {curves.map((curve) => (
        <figure key={curve.channel} className="paper-figure">
          <figcaption>{withUnit(curve.label, curve.unit)}</figcaption>
          <PhaseChart isOnPaper curve={curve} left={left} outside={outsideOf(comparison, curve.channel)} />
        </figure>
      ))}
      <ul className="paper-findings paper-small">
        {comparison.findings.map((finding) => (
          <li key={finding}>{finding}</li>
        ))}
      </ul>
      {comparison.weighted_sum && <WeightedSum sum={comparison.weighted_sum} isPaper />}
    </div>
  );
}

function Curves({ patient, course }: Omit<CourseProps, 'progress'>) {
  const first = useComparison(course.first_comparison_id);
  const newest = useComparison(course.last_comparison_id);
  if (!newest.data || !first.data) return null;
  const isOne = course.first_comparison_id === course.last_comparison_id;
  const ends = isOne ? [newest.data] : [first.data, newest.data];
  const dates = isOne ? [course.last_at] : [course.first_at, course.last_at];
  const most = ends.some((one) => one.weighted_sum) ? MOST_CURVES - 1 : MOST_CURVES;
  const words = isOne ? (['course.newest'] as const) : (['course.first', 'course.newest'] as const);
  return (
    <Sheet title={t('course.curves')} number={2} patient={patient} version={course.service_version}>
      <PhaseLegend lines={t(ends.some(isOfStrides) ? 'course.legendStrides' : 'course.legendRepetitions')} />
      <div className="paper-ends">
        {ends.map((one, index) => (
          <Ends
            key={one.id}
            comparison={one}
            curves={most}
            title={t(words[index] ?? 'course.newest', { date: date(dates[index] ?? one.created_at, EPOCH) })}
          />
        ))}
      </div>
    </Sheet>
  );
}

/** What only who studies movement reads. */
function Indices({ patient, course, progress }: CourseProps) {
  const rows = courseRows(progress.measures, { indices: true, most: Infinity });
  if (rows.length === 0) return null;
  const hasCurves = course.first_comparison_id !== null;
  return (
    <Sheet title={t('course.indices')} number={hasCurves ? 3 : 2} patient={patient} version={course.service_version}>
      <Rows rows={rows} caption={t('course.indicesTable')} />
      <p className="paper-note">{t('course.indicesHelp')}</p>
    </Sheet>
  );
}

export function CoursePage() {
  const { patientId = '' } = useParams();
  const [search] = useSearchParams();
  const exerciseId = search.get('exercise');
  const patient = usePatient(patientId);
  const course = useCourse(patientId, exerciseId);
  const progress = useProgress(patientId, exerciseId);
  const name = patient.data ? fullName(patient.data) : '';
  return (
    <Page
      compact
      title={t('course.title')}
      lead={course.data ? `${name} · ${course.data.exercise_name}` : undefined}
      crumbs={patientCrumbs(patientId, name)}
      actions={
        <Button leftSection={<IconPrinter size={19} aria-hidden />} onClick={() => window.print()}>
          {t('report.print')}
        </Button>
      }
    >
      {exerciseId === null ? (
        <Empty title={t('course.noExercise')} />
      ) : (
        <QueryBoundary of={patient} lines={8} height={40}>
          {(who) => (
            <QueryBoundary of={course} lines={8} height={40}>
              {(found) => (
                <QueryBoundary of={progress} lines={8} height={40}>
                  {(over) => (
                    <Papers>
                      <Summary patient={who} course={found} progress={over} />
                      <Curves patient={who} course={found} />
                      <Indices patient={who} course={found} progress={over} />
                    </Papers>
                  )}
                </QueryBoundary>
              )}
            </QueryBoundary>
          )}
        </QueryBoundary>
      )}
    </Page>
  );
}
