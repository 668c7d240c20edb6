// Beside the 3D view of a walk: its result, and the way to all its numbers.
import { useGait } from '../../api/queries';
import { Answer } from '../../components/Feedback';
import { t } from '../../i18n';
import { TestResult } from '../gait/TestResult';

export function WalkPanel({ sessionId }: { sessionId: string }) {
  const gait = useGait(sessionId);
  return (
    <>
      <h2 className="visually-hidden">{t('walk.result')}</h2>
      <Answer of={gait} lines={5}>
        {(data) => <TestResult gait={data} />}
      </Answer>
    </>
  );
}
