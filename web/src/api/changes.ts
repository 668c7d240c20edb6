// Every change the client asks the service for, and the answers that it makes old.
import { useMutation, useQueryClient } from '@tanstack/react-query';
import { ofPatient, ofSession, type Key } from './address';
import { byHand } from './client';
import type * as Wire from './types';

/** What a form does once its content is stored (`release` of `useUnsaved`). */
type Stored = () => void;

/** A change, and the keys that it makes old. */
function useChange<In, Out>(
  change: (input: In) => Promise<Out>,
  old: readonly Key[] | ((input: In) => readonly Key[]),
  /** Keys that are old when the service refuses: somebody else changed them meanwhile. */
  refused: readonly Key[] = [],
  /** Called as soon as the service has stored it: what became old is read anew after that, which may take long. */
  stored?: Stored,
) {
  const client = useQueryClient();
  const ask = (asked: readonly Key[]) => Promise.all(asked.map((queryKey) => client.invalidateQueries({ queryKey })));
  return useMutation<Out, Error, In>({
    mutationFn: change,
    onError: () => ask(refused),
    onSuccess: (_, input) => {
      stored?.();
      return ask(typeof old === 'function' ? old(input) : old);
    },
  });
}

export const useMarkSeen = (id: string) =>
  useChange(
    (shown: readonly Wire.Worry[]) =>
      byHand.post('/api/patients/{patient_id}/worries/seen', {
        ...ofPatient(id),
        body: { worries: shown.map(({ session_id, kind, known_at }) => ({ session_id, kind, known_at })) },
      }),
    [['patients', id, 'worries'], ['caseload']],
  );
export const useWriteCourseNote = (id: string, stored?: Stored) =>
  useChange(
    (body: Wire.CourseNoteIn) => byHand.post('/api/patients/{patient_id}/course-notes', { ...ofPatient(id), body }),
    [['patients', id, 'course']],
    [],
    stored,
  );
export const useAddPatient = (stored?: Stored) =>
  useChange((body: Wire.PatientIn) => byHand.post('/api/patients', { body }), [['patients'], ['caseload']], [], stored);
export const useEditPatient = (id: string, stored?: Stored) =>
  useChange(
    (body: Wire.PatientPatch) => byHand.patch('/api/patients/{patient_id}', { ...ofPatient(id), body }),
    [['patients', id], ['caseload'], ['patients', 'archived=true']],
    [],
    stored,
  );
export const useErasePatient = () =>
  useChange(
    (id: string) => byHand.delete('/api/patients/{patient_id}', { ...ofPatient(id), body: { confirmation: 'ERASE' } }),
    [['caseload']],
  );
export const useAddAccount = () =>
  useChange((body: Wire.AccountIn) => byHand.post('/api/accounts', { body }), [['accounts']]);
export const useChangeAccount = () =>
  useChange(
    ({ id, patch }: { id: string; patch: Wire.AccountPatch }) =>
      byHand.patch('/api/accounts/{account_id}', { path: { account_id: id }, body: patch }),
    [['accounts']],
  );
export const useChangeClinic = () =>
  useChange(
    (patch: Wire.ClinicPatch) => byHand.patch('/api/clinic', { body: patch }),
    [['clinic'], ['patients'], ['caseload']],
  );
export const useNoteSecondFactor = () => useChange(() => byHand.post('/api/me/second-factor/noted'), [['me']]);
export const useChangePassword = () =>
  useChange((body: Wire.PasswordIn) => byHand.post('/api/me/password', { body }), [['me']]);
export const useBeginSecondFactor = () =>
  useChange((body: { password: string }) => byHand.post('/api/me/second-factor', { body }), []);
export const useConfirmSecondFactor = () =>
  useChange((body: { code: string }) => byHand.post('/api/me/second-factor/confirm', { body }), [['me']]);
export const useRemoveSecondFactor = () =>
  useChange((body: { password: string }) => byHand.post('/api/me/second-factor/remove', { body }), [['me']]);
export const usePrescribe = (id: string, stored?: Stored) =>
  useChange(
    (body: Wire.PrescriptionIn) => byHand.post('/api/patients/{patient_id}/prescriptions', { ...ofPatient(id), body }),
    [['patients', id, 'prescriptions'], ['caseload']],
    [],
    stored,
  );
/** Change what is prescribed; what it was stays in its history. */
export const useChangePrescription = (id: string, stored?: Stored) =>
  useChange(
    ({ prescriptionId, ...input }: Wire.PrescriptionChangeIn & { prescriptionId: string }) =>
      byHand.patch('/api/prescriptions/{prescription_id}', { path: { prescription_id: prescriptionId }, body: input }),
    [['patients', id, 'prescriptions'], ['caseload']],
    [['patients', id, 'prescriptions']],
    stored,
  );
export const useEndPrescription = (id: string) =>
  useChange(
    (prescriptionId: string) =>
      byHand.delete('/api/prescriptions/{prescription_id}', { path: { prescription_id: prescriptionId } }),
    [['patients', id, 'prescriptions'], ['caseload']],
  );
export const useGrant = (id: string) =>
  useChange(
    (body: Wire.GrantIn) => byHand.post('/api/patients/{patient_id}/grants', { ...ofPatient(id), body }),
    [['patients', id, 'grants']],
  );
export const useRevokeGrant = (id: string) =>
  useChange(
    (grantId: string) => byHand.delete('/api/grants/{grant_id}', { path: { grant_id: grantId } }),
    [['patients', id, 'grants']],
  );
export const useAddDeviceToken = (id: string) =>
  useChange(
    (body: Wire.DeviceTokenIn) => byHand.post('/api/patients/{patient_id}/device-tokens', { ...ofPatient(id), body }),
    [['patients', id, 'device-tokens']],
  );
export const usePairingCode = (id: string) =>
  useChange(
    (body: Wire.DeviceTokenIn) => byHand.post('/api/patients/{patient_id}/pairing-codes', { ...ofPatient(id), body }),
    [],
  );
export const useRevokeDeviceToken = (id: string) =>
  useChange(
    (tokenId: string) => byHand.delete('/api/device-tokens/{token_id}', { path: { token_id: tokenId } }),
    [['patients', id, 'device-tokens']],
  );
export const useConsent = (id: string) =>
  useChange(
    (body: Wire.ConsentIn) => byHand.put('/api/patients/{patient_id}/consents', { ...ofPatient(id), body }),
    [['patients', id, 'consents']],
  );
export const useAddExercise = () =>
  useChange((body: Wire.ExerciseIn) => byHand.post('/api/exercises', { body }), [['exercises']]);
export const useChangeExercise = (id: string) =>
  useChange(
    (body: Wire.ExerciseChange) => byHand.patch('/api/exercises/{exercise_id}', { path: { exercise_id: id }, body }),
    [['exercises']],
  );
export const useNewSession = (stored?: Stored) =>
  useChange(
    (body: Wire.SessionIn) => byHand.post('/api/sessions', { body }),
    (input) => [['patients', input.patient_id, 'sessions'], ['caseload']],
    [],
    stored,
  );
export const useDeleteSession = () =>
  useChange(
    (session: { id: string; patient_id: string }) => byHand.delete('/api/sessions/{session_id}', ofSession(session.id)),
    (session) => [['patients', session.patient_id, 'sessions'], ['caseload']],
  );
export const useMoveSession = (id: string) =>
  useChange(
    (body: Wire.SessionPatch) => byHand.patch('/api/sessions/{session_id}', { ...ofSession(id), body }),
    [['sessions'], ['patients'], ['caseload']],
  );
export const useMergePatients = (id: string) =>
  useChange(
    (body: Wire.MergeIn) => byHand.post('/api/patients/{patient_id}/merge', { ...ofPatient(id), body }),
    [['patients'], ['caseload']],
  );
export const useReprocess = (id: string) =>
  useChange(
    (body: Wire.ReprocessIn) => byHand.post('/api/sessions/{session_id}/reprocess', { ...ofSession(id), body }),
    [['sessions', id, 'jobs']],
  );
export const useReprocessAll = (id: string) =>
  useChange(
    () => byHand.post('/api/sessions/{session_id}/reprocess-all', { ...ofSession(id), body: {} }),
    [['sessions', id, 'jobs']],
  );
export const useCompare = (id: string) =>
  useChange(
    (input: { template_version_id: string; result_id?: string | null }) =>
      byHand.post('/api/sessions/{session_id}/comparisons', { ...ofSession(id), body: input }),
    [['sessions', id, 'comparisons']],
  );
export const useSaveTemplate = () =>
  useChange((body: Wire.TemplateIn) => byHand.post('/api/templates', { body }), [['templates']]);
/** What was drawn on a template, as its next version. */
export const useDrawVersion = (templateId: string, stored?: Stored) =>
  useChange(
    (input: Wire.TemplateVersionIn) =>
      byHand.post('/api/templates/{template_id}/versions', { path: { template_id: templateId }, body: input }),
    [['templates']],
    [],
    stored,
  );
/** Rename, tag, retire or restore a template. */
export const useChangeTemplate = (id: string) =>
  useChange(
    (body: Wire.TemplateChange) =>
      byHand.patch('/api/templates/{template_id}/entry', { path: { template_id: id }, body }),
    [['templates']],
  );
/** Copy a version as a new template; without an exercise, for the other side. */
export const useCopyVersion = (versionId: string) =>
  useChange(
    (input: Wire.TemplateCopyIn) =>
      byHand.post('/api/template-versions/{version_id}/copies', { path: { version_id: versionId }, body: input }),
    [['templates'], ['exercises']],
  );

const NO_IMPLANTS = { patient_has_no_implant: true, people_nearby_have_none: true } as const;
/** A session with a source, and the therapist's word about implants. Should the word be lost, its page asks again. */
export const useNewSourceSession = () =>
  useChange(
    async (input: Wire.SessionIn) => {
      const session = await byHand.post('/api/sessions', { body: input });
      await byHand
        .post('/api/sessions/{session_id}/magnetic-safety', { ...ofSession(session.id), body: NO_IMPLANTS })
        .catch(() => undefined);
      return session;
    },
    (input) => [['patients', input.patient_id, 'sessions'], ['caseload']],
  );
export const useConfirmNoImplants = (id: string) =>
  useChange(
    () => byHand.post('/api/sessions/{session_id}/magnetic-safety', { ...ofSession(id), body: NO_IMPLANTS }),
    [['sessions', id]],
  );
export const useWithdrawSafety = (id: string) =>
  useChange(() => byHand.delete('/api/sessions/{session_id}/magnetic-safety', ofSession(id)), [['sessions', id]]);
export const useKeepSource = () =>
  useChange(
    (source: Wire.MagneticSourceIn) => byHand.post('/api/magnetic-sources', { body: source }),
    [['magnetic-sources']],
  );
export const useRetireSource = () =>
  useChange(
    (id: string) => byHand.delete('/api/magnetic-sources/{source_id}', { path: { source_id: id } }),
    [['magnetic-sources']],
  );
export const useCalibrateSource = (id: string) =>
  useChange(
    (wanted: Wire.SourceCalibrationIn) =>
      byHand.post('/api/sessions/{session_id}/source-calibration', { ...ofSession(id), body: wanted }),
    [['magnetic-sources']],
  );
