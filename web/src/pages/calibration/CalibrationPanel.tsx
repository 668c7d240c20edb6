// The guided calibration beside the live view: choose, follow the steps, read what came of it.
import { useState } from 'react';
import { useCalibrations } from '../../api/queries';
import type { CalibrationIn, CalibrationMessage, Placement } from '../../api/types';
import { Problem } from '../../components/Feedback';
import { t } from '../../i18n';
import { isRunning } from '../../lib/calibration';
import { CalibrationChoice } from './CalibrationChoice';
import { CalibrationResult } from './CalibrationResult';
import { RunningCalibration } from './RunningCalibration';
import { useCalibrating } from './useCalibrating';

export interface CalibrationPanelProps {
  sessionId: string;
  placements: readonly Placement[];
  guide: CalibrationMessage | null;
  hint: string;
  mayAct: boolean;
  /** What of it stands on the page. */
  shows: Shows;
  /** Nothing is in force yet: the choice is shown without being asked for. */
  isNeeded: boolean;
  /** How the sensors sit is remembered from an earlier session; only the directions are missing. */
  isRemembered?: boolean;
  /** A result was read. */
  onRead: (result: CalibrationMessage) => void;
  onClose: () => void;
}

type Shows = 'running' | 'result' | 'choice';

/** What stands on the page: a calibration that runs, a result that nobody has read, or the choice where it is wanted. */
export function panelOf(
  guide: CalibrationMessage | null,
  read: CalibrationMessage | null,
  isWanted: boolean,
): Shows | null {
  if (guide && isRunning(guide)) return 'running';
  if (guide && guide !== read && (guide.phase === 'done' || guide.phase === 'redo')) return 'result';
  return isWanted ? 'choice' : null;
}

export function CalibrationPanel({
  sessionId,
  placements,
  guide,
  hint,
  mayAct,
  shows,
  isNeeded,
  isRemembered,
  onRead,
  onClose,
}: CalibrationPanelProps) {
  const guides = useCalibrations(guide !== null);
  const { start, next, cancel, error } = useCalibrating(sessionId);
  const [last, setLast] = useState<CalibrationIn | null>(null);
  const begin = (wanted: CalibrationIn) => {
    setLast(wanted);
    next.reset();
    cancel.reset();
    start.mutate(wanted);
  };
  const title = guides.data?.find((one) => one.kind === guide?.kind)?.title ?? '';
  // All limbs at once, the first time: whichever way the patient faces, unlike the correction of one limb.
  const isFirstHeading = guide?.kind === 'heading_reset' && (isRemembered ?? false);
  return (
    <>
      {error && <Problem error={error} />}
      {guide && shows === 'running' ? (
        <RunningCalibration
          guide={guide}
          placements={placements}
          title={isFirstHeading ? t('calibration.setDirections') : title}
          instruction={isFirstHeading ? t('calibration.directionsPose') : undefined}
          mayAct={mayAct}
          isBusy={next.isPending}
          onNext={() => next.mutate()}
          onCancel={() => cancel.mutate()}
        />
      ) : guide && shows === 'result' ? (
        <CalibrationResult
          guide={guide}
          mayAct={mayAct}
          isBusy={start.isPending}
          onAgain={() => begin(last?.kind === guide.kind ? last : { kind: guide.kind })}
          onClose={() => {
            onRead(guide);
            if (guide.phase === 'done') onClose();
          }}
        />
      ) : (
        <CalibrationChoice
          placements={placements}
          hint={hint}
          isRemembered={isRemembered}
          mayAct={mayAct}
          isBusy={start.isPending}
          onStart={begin}
          onClose={isNeeded ? undefined : onClose}
        />
      )}
    </>
  );
}
