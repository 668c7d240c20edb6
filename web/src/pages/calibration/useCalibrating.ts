// The deeds of a guided calibration, apart from its panel: the patient's page has buttons of its own.
import { useMutation } from '@tanstack/react-query';
import { ofSession } from '../../api/address';
import { byHand } from '../../api/client';
import type { CalibrationIn } from '../../api/types';

/** Begin, go on with and cancel a guided calibration of a session. */
export function useCalibrating(sessionId: string) {
  const of = ofSession(sessionId);
  const start = useMutation({
    mutationFn: (body: CalibrationIn) => byHand.post('/api/sessions/{session_id}/calibration/start', { ...of, body }),
  });
  const next = useMutation({ mutationFn: () => byHand.post('/api/sessions/{session_id}/calibration/next', of) });
  const cancel = useMutation({ mutationFn: () => byHand.post('/api/sessions/{session_id}/calibration/cancel', of) });
  return { start, next, cancel, error: start.error ?? next.error ?? cancel.error };
}
