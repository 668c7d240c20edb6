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
  /** Whether the choice stays open although a calibration is in force. */
  isAsked: boolean;
  /** Nothing is in force yet: the choice is shown without being asked for. */
  isNeeded: boolean;
  /** How the sensors sit is remembered from an earlier session; only the directions are missing. */
  isRemembered?: boolean;
  onClose: () => void;
}

export function CalibrationPanel({
  sessionId,
  placements,
  guide,
  hint,
  mayAct,
  isAsked,
  isNeeded,
  isRemembered,
  onClose,
}: CalibrationPanelProps) {
  const guides = useCalibrations(guide !== null);
  const { start, next, cancel, error } = useCalibrating(sessionId);
  const [last, setLast] = useState<CalibrationIn | null>(null);
  // A result that was read is put away; the next message of a running calibration brings the guide back.
  const [read, setRead] = useState<CalibrationMessage | null>(null);
  const begin = (wanted: CalibrationIn) => {
    setLast(wanted);
    next.reset();
    cancel.reset();
    start.mutate(wanted);
  };
  const title = guides.data?.find((one) => one.kind === guide?.kind)?.title ?? '';
  // All limbs at once, the first time: whichever way the patient faces, unlike the correction of one limb.
  const isFirstHeading = guide?.kind === 'heading_reset' && (isRemembered ?? false);
  const hasResult = guide !== null && (guide.phase === 'done' || guide.phase === 'redo') && guide !== read;
  return (
    <>
      {error && <Problem error={error} />}
      {guide && isRunning(guide) ? (
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
      ) : hasResult ? (
        <CalibrationResult
          guide={guide}
          mayAct={mayAct}
          isBusy={start.isPending}
          onAgain={() => begin(last?.kind === guide.kind ? last : { kind: guide.kind })}
          onClose={() => {
            setRead(guide);
            if (guide.phase === 'done') onClose();
          }}
        />
      ) : (
        (isNeeded || isAsked) && (
          <CalibrationChoice
            placements={placements}
            hint={hint}
            isRemembered={isRemembered}
            mayAct={mayAct}
            isBusy={start.isPending}
            onStart={begin}
            onClose={isNeeded ? undefined : onClose}
          />
        )
      )}
    </>
  );
}
