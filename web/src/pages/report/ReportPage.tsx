// The report: one sheet that a colleague or a payer understands, one of curves, one of method and quality.
import { Button } from '@mantine/core';
import { IconPrinter } from '@tabler/icons-react';
import { useParams } from 'react-router';
import {
  useComparison,
  useComparisons,
  useEstimators,
  useExercises,
  usePatient,
  useProgress,
  useSession,
  useTemplateVersion,
} from '../../api/queries';
import type { Patient, SessionDetail } from '../../api/types';
import { QueryBoundary } from '../../components/Feedback';
import { Page } from '../../components/Page';
import { t } from '../../i18n';
import { dateTime } from '../../lib/format';
import { fullName, patientCrumbs } from '../../lib/people';
import { CurvesSheet } from './CurvesSheet';
import { MethodSheet } from './MethodSheet';
import { Papers } from './Papers';
import type { ReportProps } from './Sheet';
import { SummarySheet } from './SummarySheet';
import { panelsOf } from '../../kinds/panels';
import { sessionTitle } from '../../lib/sessions';

function Sheets({ session, patient }: { session: SessionDetail; patient: Patient }) {
  const comparisons = useComparisons(session.id);
  const of =
    (comparisons.data ?? []).find((one) => one.result_id === session.main_result_id) ?? comparisons.data?.[0] ?? null;
  const comparison = useComparison(of?.id ?? null);
  const progress = useProgress(patient.id, session.exercise_id ?? null, session.id);
  const template = useTemplateVersion(of?.template_version_id ?? null);
  const estimators = useEstimators();
  const exercises = useExercises();
  const isWaiting = comparisons.isPending || progress.isPending || (of !== null && comparison.isPending);
  if (isWaiting)
    return (
      <QueryBoundary
        of={{
          data: undefined,
          error: comparisons.error ?? progress.error ?? comparison.error,
          refetch: () => void comparisons.refetch(),
        }}
      >
        {() => null}
      </QueryBoundary>
    );
  const report: ReportProps = {
    session,
    patient,
    comparison: comparison.data ?? null,
    progress: progress.data ?? null,
  };
  return (
    <Papers>
      <SummarySheet {...report} />
      {report.comparison && report.comparison.repetitions.length > 0 && (
        <CurvesSheet {...report} comparison={report.comparison} />
      )}
      <MethodSheet
        {...report}
        template={template.data ?? null}
        estimators={estimators.data ?? []}
        exercise={exercises.data?.find((one) => one.id === session.exercise_id) ?? null}
      />
    </Papers>
  );
}

export function ReportPage() {
  const { sessionId = '' } = useParams();
  const session = useSession(sessionId);
  const patient = usePatient(session.data?.patient_id ?? '');
  const name = patient.data ? fullName(patient.data) : '';
  return (
    <Page
      compact
      title={t('report.title')}
      lead={session.data ? `${name} · ${dateTime(session.data.started_at ?? session.data.created_at)}` : undefined}
      crumbs={[
        ...patientCrumbs(session.data?.patient_id, name),
        ...(session.data ? [{ to: `/sessions/${session.data.id}`, text: sessionTitle(session.data) }] : []),
      ]}
      actions={
        <Button leftSection={<IconPrinter size={19} aria-hidden />} onClick={() => window.print()}>
          {t('report.print')}
        </Button>
      }
    >
      <QueryBoundary of={session} lines={8} height={40}>
        {(one) => (
          <QueryBoundary of={patient} lines={8} height={40}>
            {(who) => {
              const Report = panelsOf(one).Report ?? Sheets;
              return <Report session={one} patient={who} />;
            }}
          </QueryBoundary>
        )}
      </QueryBoundary>
    </Page>
  );
}
