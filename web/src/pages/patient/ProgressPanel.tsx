import { Button, Select } from '@mantine/core';
import { IconChartLine } from '@tabler/icons-react';
import { useState } from 'react';
import { Link } from 'react-router';
import { useEstimators, usePrescriptions, useProgress } from '../../api/queries';
import type { Progress, ProgressMeasure } from '../../api/types';
import { BandLegend, EventStrip, ProgressChart } from '../../charts/ProgressChart';
import { QueryBoundary, Empty } from '../../components/Feedback';
import { t } from '../../i18n';
import { isSure, judgedBy, trendNotes, trendText } from '../../lib/assessment/trend';
import { quantity } from '../../lib/format';
import './ProgressPanel.css';

const SHOWN_FIRST = 3;

function Measure({ measure, events }: { measure: ProgressMeasure; events: Progress['events'] }) {
  const estimators = useEstimators().data ?? [];
  const last = measure.points.at(-1);
  return (
    <div className="measure">
      <div className="measure-head">
        <h3>{measure.label}</h3>
        {last && (
          <span className="measure-value number">
            {quantity(last.value, measure.unit)}
            <span className="muted small"> {t('progress.lastSession', { count: last.count })}</span>
          </span>
        )}
        <p className={isSure(measure) ? 'strong' : 'muted'}>{trendText(measure)}</p>
        {trendNotes(measure).map((note) => (
          <p key={note}>{note}</p>
        ))}
        <p className="muted small">{judgedBy(measure)}</p>
      </div>
      {measure.points.length > 1 ? (
        <ProgressChart measure={measure} events={events} estimators={estimators} />
      ) : (
        <BandLegend bands={measure.bands} unit={measure.unit} />
      )}
    </div>
  );
}

function Measures({ progress, patientId, mayTreat }: { progress: Progress; patientId: string; mayTreat: boolean }) {
  const [showsAll, setShowsAll] = useState(false);
  const measures = progress.measures.filter((measure) => measure.points.length > 0);
  if (measures.length === 0) {
    return (
      <Empty
        level={3}
        icon={<IconChartLine size={44} aria-hidden />}
        title={t('progress.emptyTitle')}
        action={
          mayTreat && (
            <Button component={Link} to={`/patients/${patientId}/sessions/new`}>
              {t('session.start')}
            </Button>
          )
        }
      >
        {t('progress.emptyText')}
      </Empty>
    );
  }
  const shown = showsAll ? measures : measures.slice(0, SHOWN_FIRST);
  return (
    <>
      <EventStrip events={progress.events} />
      {shown.map((measure) => (
        <Measure key={measure.measure} measure={measure} events={progress.events} />
      ))}
      {measures.length > SHOWN_FIRST && (
        <Button variant="default" onClick={() => setShowsAll(!showsAll)} aria-expanded={showsAll}>
          {showsAll ? t('progress.fewer') : t('progress.more', { count: measures.length - SHOWN_FIRST })}
        </Button>
      )}
    </>
  );
}

export function ProgressPanel({ patientId, mayTreat }: { patientId: string; mayTreat: boolean }) {
  const [exerciseId, setExerciseId] = useState<string | null>(null);
  const prescriptions = usePrescriptions(patientId);
  const progress = useProgress(patientId, exerciseId);
  const exercises = [
    ...new Map((prescriptions.data ?? []).map((one) => [one.exercise_id, one.exercise_name])).entries(),
  ];
  const newest = progress.data?.exercise_id ?? null;
  // What was practised last may be prescribed to nobody; the way back to what is must stay open.
  const isOther =
    exerciseId === null &&
    progress.data !== undefined &&
    progress.data.measures.length > 0 &&
    !exercises.some(([id]) => id === newest);
  const [wasOther, setWasOther] = useState(false);
  if (isOther && !wasOther) setWasOther(true);
  const choices = [
    ...(wasOther ? [{ value: '', label: t('progress.newest') }] : []),
    ...exercises.map(([value, label]) => ({ value, label })),
  ];
  const chosen = exerciseId ?? (wasOther ? '' : (newest ?? exercises[0]?.[0] ?? null));
  return (
    <section className="card" aria-labelledby="progress">
      <div className="card-head">
        <h2 id="progress">{t('progress.title')}</h2>
        {choices.length > 1 && (
          <Select
            className="end"
            size="sm"
            w={260}
            aria-label={t('progress.exercise')}
            data={choices}
            value={chosen}
            onChange={(value) => setExerciseId(value || null)}
          />
        )}
      </div>
      {progress.data?.exercise_id && progress.data.measures.length > 0 && (
        <p>
          <Link to={`/patients/${patientId}/report?exercise=${progress.data.exercise_id}`}>{t('course.open')}</Link>
        </p>
      )}
      <QueryBoundary of={progress} lines={6} height={50}>
        {(data) => <Measures progress={data} patientId={patientId} mayTreat={mayTreat} />}
      </QueryBoundary>
    </section>
  );
}
