// The deeds of a guided calibration, apart from its panel: the patient's page has buttons of its own.
import { useMutation } from '@tanstack/react-query';
import { byHand } from '../../api/client';
import type { CalibrationIn, CalibrationMessage } from '../../api/types';

/** Begin, go on with and cancel a guided calibration of a session. */
export function useCalibrating(sessionId: string) {
  const path = `/api/sessions/${sessionId}/calibration`;
  const start = useMutation({
    mutationFn: (wanted: CalibrationIn) => byHand.post<CalibrationMessage>(`${path}/start`, wanted),
  });
  const next = useMutation({ mutationFn: () => byHand.post<CalibrationMessage>(`${path}/next`) });
  const cancel = useMutation({ mutationFn: () => byHand.post<CalibrationMessage>(`${path}/cancel`) });
  return { start, next, cancel, error: start.error ?? next.error ?? cancel.error };
}
