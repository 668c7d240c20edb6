// Below the 3D view of a walk its footprints; beside it the result, and left beside right.
import { useGait, usePatient } from '../../../api/queries';
import type { Gait } from '../../../api/types';
import { QueryBoundary } from '../../../components/Feedback';
import { t } from '../../../i18n';
import { MapCard } from './MapCard';
import { TestResult } from './TestResult';
import { WalkNumbers } from './WalkNumbers';

const hasStrides = (gait: Gait) => gait.feet.some((foot) => foot.strides.length > 0);

export function WalkPanel({ sessionId, patientId }: { sessionId: string; patientId: string }) {
  const gait = useGait(sessionId);
  const patient = usePatient(patientId);
  return (
    <>
      <h2 className="visually-hidden">{t('walk.result')}</h2>
      <QueryBoundary of={gait} lines={5}>
        {(data) => (
          <div className="stack">
            <TestResult gait={data} />
            {hasStrides(data) && (
              <WalkNumbers gait={data} before={null} affected={patient.data?.affected_side ?? null} />
            )}
          </div>
        )}
      </QueryBoundary>
    </>
  );
}

/** Nothing until it is there: the panel beside says what is amiss. */
export function WalkMap({ sessionId }: { sessionId: string }) {
  const { data } = useGait(sessionId);
  return data && hasStrides(data) ? <MapCard gait={data} selected={null} /> : null;
}
