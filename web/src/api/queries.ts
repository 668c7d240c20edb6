// Every question the client asks the service, with one key each, so a change refreshes what it touched.
import {
  useInfiniteQuery,
  useMutation,
  useQuery,
  useQueryClient,
  type InfiniteData,
  queryOptions,
  type QueryClient,
} from '@tanstack/react-query';
import { api, ApiError, byHand, setCsrfToken, withQuery, type ListPage } from './client';
import type * as Wire from './types';
import { speakLanguage, wanted } from '../i18n/languages';
import { forgetDrafts, forgetDraftsOfOthers } from '../lib/editing/drafts';
import { releaseAll } from '../lib/editing/unsaved';
import { holdStoreKey } from '../sensors/gateway/seal';
import { stopMeasuring } from '../sensors/registry';

export const keys = {
  me: ['me'] as const,
  secondFactor: ['second-factor'] as const,
  caseload: ['caseload'] as const,
  demonstration: ['demonstration'] as const,
  patients: ['patients'] as const,
  archived: ['patients', 'archived'] as const,
  patient: (id: string) => ['patients', id] as const,
  course: (id: string, exerciseId: string) => ['patients', id, 'course', exerciseId] as const,
  answers: (id: string) => ['sessions', id, 'answers'] as const,
  version: ['version'] as const,
  progress: (id: string, exerciseId: string | null, until: string | null = null) =>
    ['patients', id, 'progress', exerciseId, until] as const,
  patientSessions: (id: string) => ['patients', id, 'sessions'] as const,
  prescriptions: (id: string) => ['patients', id, 'prescriptions'] as const,
  grants: (id: string) => ['patients', id, 'grants'] as const,
  deviceTokens: (id: string) => ['patients', id, 'device-tokens'] as const,
  consents: (id: string) => ['patients', id, 'consents'] as const,
  worries: (id: string) => ['patients', id, 'worries'] as const,
  audit: (id: string) => ['patients', id, 'audit'] as const,
  accounts: ['accounts'] as const,
  clinic: ['clinic'] as const,
  exercises: ['exercises'] as const,
  templates: (exerciseId: string | null, patientId: string | null) => ['templates', exerciseId, patientId] as const,
  templateVersion: (id: string) => ['template-versions', id] as const,
  session: (id: string) => ['sessions', id] as const,
  sessionJobs: (id: string) => ['sessions', id, 'jobs'] as const,
  comparisons: (id: string) => ['sessions', id, 'comparisons'] as const,
  magneticSources: ['magnetic-sources'] as const,
  sourceStops: (id: string) => ['sessions', id, 'source-stops'] as const,
  magneticSafety: (id: string) => ['sessions', id, 'magnetic-safety'] as const,
  sourceUse: (id: string, resultId: string | null) => ['sessions', id, 'source-use', resultId] as const,
  series: (id: string, names: string, resultId: string | null) => ['sessions', id, 'series', names, resultId] as const,
  markers: (id: string) => ['sessions', id, 'markers'] as const,
  markerMotion: (id: string, markersId: string, block: number) =>
    ['sessions', id, 'markers', markersId, block] as const,
  gait: (id: string) => ['sessions', id, 'gait'] as const,
  walks: (id: string) => ['patients', id, 'walks'] as const,
  conditions: (id: string, a: readonly string[], b: readonly string[]) =>
    ['patients', id, 'walks', 'conditions', a, b] as const,
  comparison: (id: string) => ['comparisons', id] as const,
  estimators: ['estimators'] as const,
  formats: ['formats'] as const,
  differences: (id: string, a: string, b: string) => ['sessions', id, 'differences', a, b] as const,
  calibrations: ['calibrations'] as const,
  accuracy: ['accuracy'] as const,
  job: (id: string) => ['jobs', id] as const,
};

/** Take over who has signed in: the token of changes, and the language. */
export async function acceptMe(me: Wire.Me): Promise<Wire.Me> {
  setCsrfToken(me.csrf_token, me.account_id);
  holdStoreKey(me.store_key);
  await speakLanguage(wanted(me.locale));
  return me;
}

/** Who is signed in; null when nobody is. */
export const meQuery = queryOptions({
  queryKey: keys.me,
  queryFn: async ({ signal }): Promise<Wire.Me | null> => {
    try {
      return await acceptMe(await api.get<Wire.Me>('/api/me', signal));
    } catch (error) {
      if (error instanceof ApiError && error.status === 401) return null;
      throw error;
    }
  },
  staleTime: Infinity,
});

export const useMe = () => useQuery(meQuery);

export function useSignIn() {
  const client = useQueryClient();
  return useMutation({
    mutationFn: async (request: Wire.SignInRequest) => acceptMe(await api.post<Wire.Me>('/api/sign-in', request)),
    onSuccess: (me) => {
      stopMeasuring();
      forgetDraftsOfOthers(me.account_id);
      client.clear();
      client.setQueryData(keys.me, me);
    },
  });
}

/** After signing out nothing of the patient data may stay in memory or on this device. */
export function forgetEverything(client: QueryClient): void {
  stopMeasuring();
  releaseAll();
  forgetDrafts();
  setCsrfToken('');
  holdStoreKey('');
  client.clear();
  client.setQueryData(keys.me, null);
}

export function useGet<T>(
  queryKey: readonly unknown[],
  path: string,
  options: { enabled?: boolean; refetchInterval?: number; staleTime?: number } = {},
) {
  return useQuery({ queryKey, queryFn: ({ signal }) => api.get<T>(path, signal), ...options });
}

const rowsOf = <T>(data: InfiniteData<ListPage<T>>): T[] => data.pages.flatMap((page) => page.rows);

/** A list that people read: its first page, and further ones when they ask (`ShowMore`). */
function usePages<T>(
  queryKey: readonly unknown[],
  path: string,
  options: { enabled?: boolean; refetchInterval?: number } = {},
) {
  return useInfiniteQuery({
    queryKey,
    queryFn: ({ pageParam, signal }) => api.page<T>(pageParam, signal),
    initialPageParam: path,
    getNextPageParam: (last) => last.next,
    select: rowsOf<T>,
    ...options,
  });
}

/** A list of which every row is needed. */
function useAll<T>(queryKey: readonly unknown[], path: string, options: { enabled?: boolean } = {}) {
  return useQuery({ queryKey, queryFn: ({ signal }) => api.all<T>(path, signal), ...options });
}

/** What a form does once its content is stored (`release` of `useUnsaved`). */
type Stored = () => void;

/** A change, and the keys that it makes old. */
function useChange<In, Out>(
  change: (input: In) => Promise<Out>,
  old: (input: In, output: Out) => readonly (readonly unknown[])[],
  /** Keys that are old when the service refuses: somebody else changed them meanwhile. */
  refused: readonly (readonly unknown[])[] = [],
  /** Called as soon as the service has stored it: what became old is read anew after that, which may take long. */
  stored?: Stored,
) {
  const client = useQueryClient();
  return useMutation<Out, Error, In>({
    mutationFn: change,
    onError: () => Promise.all(refused.map((queryKey) => client.invalidateQueries({ queryKey }))).then(() => undefined),
    onSuccess: (output, input) => {
      stored?.();
      return Promise.all(old(input, output).map((queryKey) => client.invalidateQueries({ queryKey }))).then(
        () => undefined,
      );
    },
  });
}

/** How far the past sessions of the demonstration are; null elsewhere, and nobody asks again then. */
export const useDemonstration = () =>
  useQuery({
    queryKey: keys.demonstration,
    queryFn: ({ signal }) => api.get<Wire.Demonstration | null>('/api/demonstration', signal),
    refetchInterval: (query) => (query.state.data ? 3_000 : false),
    staleTime: Infinity,
  });
export const useCaseload = () =>
  usePages<Wire.CaseloadRow>(keys.caseload, '/api/caseload', { refetchInterval: 15_000 });
export const usePatients = () => useAll<Wire.Patient>(keys.patients, '/api/patients');
export const useArchivedPatients = () => usePages<Wire.Patient>(keys.archived, '/api/patients?archived=true');
export const usePatient = (id: string) =>
  useGet<Wire.Patient>(keys.patient(id), `/api/patients/${id}`, { enabled: id !== '' });
/** With `until`, a session, as it was known with that one. */
export const useProgress = (id: string, exerciseId: string | null, until: string | null = null) =>
  useGet<Wire.Progress>(
    keys.progress(id, exerciseId, until),
    withQuery(`/api/patients/${id}/progress`, { exercise_id: exerciseId, until }),
  );
export const useAnswers = (id: string, isAsked = true) =>
  useGet<Wire.Answers>(keys.answers(id), `/api/sessions/${id}/answers`, { enabled: isAsked });
export const useCourse = (id: string, exerciseId: string | null) =>
  useGet<Wire.Course>(
    keys.course(id, exerciseId ?? ''),
    withQuery(`/api/patients/${id}/course`, { exercise_id: exerciseId }),
    { enabled: exerciseId !== null },
  );
/** What happened in a patient's sessions that a therapist must have seen, seen or not; the newest first. */
export const usePatientWorries = (id: string) => useAll<Wire.Worry>(keys.worries(id), `/api/patients/${id}/worries`);
export const useMarkSeen = (id: string) =>
  useChange(
    (shown: readonly Wire.Worry[]) =>
      byHand.post<Wire.Worry[]>(`/api/patients/${id}/worries/seen`, {
        worries: shown.map(({ session_id, kind, known_at }) => ({ session_id, kind, known_at })),
      }),
    () => [keys.worries(id), keys.caseload],
  );
/** Version of the software that answers. */
export const useVersion = () => useGet<{ version: string }>(keys.version, '/api/health');
export const useWriteCourseNote = (id: string, stored?: Stored) =>
  useChange(
    (input: Wire.CourseNoteIn) => byHand.post<Wire.CourseNote>(`/api/patients/${id}/course-notes`, input),
    () => [['patients', id, 'course']],
    [],
    stored,
  );
export const usePatientSessions = (id: string, enabled = true) =>
  usePages<Wire.Session>(keys.patientSessions(id), `/api/patients/${id}/sessions`, { enabled: enabled && id !== '' });
export const usePrescriptions = (id: string) =>
  useGet<Wire.Prescription[]>(keys.prescriptions(id), `/api/patients/${id}/prescriptions`, { enabled: id !== '' });
export const useGrants = (id: string, enabled = true) =>
  useGet<Wire.Grant[]>(keys.grants(id), `/api/patients/${id}/grants`, { enabled });
export const useDeviceTokens = (id: string, enabled = true) =>
  useAll<Wire.DeviceToken>(keys.deviceTokens(id), `/api/patients/${id}/device-tokens`, { enabled });
export const useConsents = (id: string) => useGet<Wire.Consent[]>(keys.consents(id), `/api/patients/${id}/consents`);
export const useAudit = (id: string, enabled = true) =>
  usePages<Wire.AuditEntry>(keys.audit(id), `/api/patients/${id}/audit`, { enabled });
export const useAccounts = (enabled = true) => useAll<Wire.Account>(keys.accounts, '/api/accounts', { enabled });
export const useClinic = () => useGet<Wire.Clinic>(keys.clinic, '/api/clinic');
export const useExercises = () => useGet<Wire.Exercise[]>(keys.exercises, '/api/exercises', { staleTime: 60_000 });
export const useTemplates = (
  exerciseId: string | null,
  patientId: string | null,
  enabled = true,
  withRetired = false,
) =>
  useAll<Wire.Template>(
    [...keys.templates(exerciseId, patientId), withRetired],
    withQuery('/api/templates', {
      exercise_id: exerciseId,
      patient_id: patientId,
      is_retired: withRetired ? 'true' : null,
    }),
    { enabled },
  );
/** Templates of the clinic whose name, exercise or tags hold all the words. */
export const useTemplateSearch = (words: string, withRetired: boolean) =>
  usePages<Wire.Template>(
    ['templates', 'search', words, withRetired],
    withQuery('/api/templates', { words, is_retired: withRetired ? 'true' : null }),
  );
export const useTemplateVersion = (id: string | null) =>
  useGet<Wire.TemplateVersionDetail>(keys.templateVersion(id ?? ''), `/api/template-versions/${id}`, {
    enabled: id !== null,
    staleTime: Infinity,
  });
export const useSession = (id: string, refetchInterval?: number) =>
  useGet<Wire.SessionDetail>(keys.session(id), `/api/sessions/${id}`, { enabled: id !== '', refetchInterval });
/** The newest tasks: a page holds more than a session has at once. */
export const useSessionJobs = (id: string, refetchInterval?: number) =>
  useGet<Wire.Job[]>(keys.sessionJobs(id), `/api/sessions/${id}/jobs`, { refetchInterval, enabled: id !== '' });
export const useMarkers = (id: string) => useAll<Wire.Markers>(keys.markers(id), `/api/sessions/${id}/markers`);
/** Fused motion in blocks of so many seconds, so that a long session is fetched as it is looked at. */
export const MOTION_BLOCK_S = 20;
export const useMarkerMotion = (id: string, markersId: string, block: number) =>
  useGet<Wire.MarkerMotion>(
    keys.markerMotion(id, markersId, block),
    withQuery(`/api/sessions/${id}/markers/motion/stretch`, {
      markers_id: markersId,
      from_s: block * MOTION_BLOCK_S,
      until_s: (block + 1) * MOTION_BLOCK_S,
    }),
    { staleTime: Infinity },
  );
export const useComparisons = (id: string) =>
  useAll<Wire.Comparison>(keys.comparisons(id), `/api/sessions/${id}/comparisons`);
export const useComparison = (id: string | null) =>
  useGet<Wire.ComparisonDetail>(keys.comparison(id ?? ''), `/api/comparisons/${id}`, {
    enabled: id !== null,
    staleTime: Infinity,
  });
export const useEstimators = () =>
  useGet<Wire.Estimator[]>(keys.estimators, '/api/estimators', { staleTime: Infinity });

export const useFormats = () => useGet<Wire.Format[]>(keys.formats, '/api/uploads/formats', { staleTime: Infinity });

export const useCalibrations = (enabled = true) =>
  useGet<Wire.CalibrationGuide[]>(keys.calibrations, '/api/calibrations', { staleTime: Infinity, enabled });
export const useAccuracy = () => useGet<Wire.AccuracyReport>(keys.accuracy, '/api/accuracy', { staleTime: Infinity });

/** A long task, asked for twice a second until it ends. */
export function useJob(id: string | null, onEnd?: (job: Wire.Job) => void) {
  const client = useQueryClient();
  return useQuery({
    queryKey: keys.job(id ?? ''),
    enabled: id !== null,
    queryFn: async ({ signal }) => {
      const job = await api.get<Wire.Job>(`/api/jobs/${id}`, signal);
      if (job.status === 'complete' || job.status === 'failed') {
        await client.invalidateQueries({ queryKey: keys.session(job.session_id) });
        onEnd?.(job);
      }
      return job;
    },
    refetchInterval: (query) => {
      const status = query.state.data?.status;
      return status === 'complete' || status === 'failed' ? false : 500;
    },
  });
}

export const useAddPatient = (stored?: Stored) =>
  useChange(
    (input: Wire.PatientIn) => byHand.post<Wire.Patient>('/api/patients', input),
    () => [keys.patients, keys.caseload],
    [],
    stored,
  );
export const useEditPatient = (id: string, stored?: Stored) =>
  useChange(
    (input: Wire.PatientPatch) => byHand.patch<Wire.Patient>(`/api/patients/${id}`, input),
    () => [keys.patient(id), keys.caseload, keys.archived],
    [],
    stored,
  );
export const useErasePatient = () =>
  useChange(
    (id: string) => byHand.delete<void>(`/api/patients/${id}`, { confirmation: 'ERASE' }),
    () => [keys.caseload],
  );
export const useAddAccount = () =>
  useChange(
    (input: Wire.AccountIn) => byHand.post<Wire.Account>('/api/accounts', input),
    () => [keys.accounts],
  );
export const useChangeAccount = () =>
  useChange(
    ({ id, patch }: { id: string; patch: Wire.AccountPatch }) =>
      byHand.patch<Wire.Account>(`/api/accounts/${id}`, patch),
    () => [keys.accounts],
  );
export const useChangeClinic = () =>
  useChange(
    (patch: Wire.ClinicPatch) => byHand.patch<Wire.Clinic>('/api/clinic', patch),
    () => [keys.clinic, keys.patients, keys.caseload],
  );
export const useNoteSecondFactor = () =>
  useChange(
    () => byHand.post<void>('/api/me/second-factor/noted'),
    () => [keys.me],
  );
export const useChangePassword = () =>
  useChange(
    (input: Wire.PasswordIn) => byHand.post<void>('/api/me/password', input),
    () => [keys.me],
  );
export const useSecondFactor = () => useGet<Wire.SecondFactor>(keys.secondFactor, '/api/me/second-factor');
export const useBeginSecondFactor = () =>
  useChange(
    (input: { password: string }) => byHand.post<Wire.SecondFactorSetup>('/api/me/second-factor', input),
    () => [],
  );
export const useConfirmSecondFactor = () =>
  useChange(
    (input: { code: string }) => byHand.post<Wire.RecoveryCodes>('/api/me/second-factor/confirm', input),
    () => [keys.secondFactor, keys.me],
  );
export const useRemoveSecondFactor = () =>
  useChange(
    (input: { password: string }) => byHand.post<void>('/api/me/second-factor/remove', input),
    () => [keys.secondFactor, keys.me],
  );
export const usePrescribe = (id: string, stored?: Stored) =>
  useChange(
    (input: Wire.PrescriptionIn) => byHand.post<Wire.Prescription>(`/api/patients/${id}/prescriptions`, input),
    () => [keys.prescriptions(id), keys.caseload],
    [],
    stored,
  );
/** Change what is prescribed; what it was stays in its history. */
export const useChangePrescription = (id: string, stored?: Stored) =>
  useChange(
    ({ prescriptionId, ...input }: Wire.PrescriptionChangeIn & { prescriptionId: string }) =>
      byHand.patch<Wire.Prescription>(`/api/prescriptions/${prescriptionId}`, input),
    () => [keys.prescriptions(id), keys.caseload],
    [keys.prescriptions(id)],
    stored,
  );
export const useEndPrescription = (id: string) =>
  useChange(
    (prescriptionId: string) => byHand.delete<void>(`/api/prescriptions/${prescriptionId}`),
    () => [keys.prescriptions(id), keys.caseload],
  );
export const useGrant = (id: string) =>
  useChange(
    (input: Wire.GrantIn) => byHand.post<Wire.Grant>(`/api/patients/${id}/grants`, input),
    () => [keys.grants(id)],
  );
export const useRevokeGrant = (id: string) =>
  useChange(
    (grantId: string) => byHand.delete<void>(`/api/grants/${grantId}`),
    () => [keys.grants(id)],
  );
export const useAddDeviceToken = (id: string) =>
  useChange(
    (input: Wire.DeviceTokenIn) => byHand.post<Wire.DeviceToken>(`/api/patients/${id}/device-tokens`, input),
    () => [keys.deviceTokens(id)],
  );
export const usePairingCode = (id: string) =>
  useChange(
    (input: Wire.DeviceTokenIn) => byHand.post<Wire.PairingCode>(`/api/patients/${id}/pairing-codes`, input),
    () => [],
  );
export const useRevokeDeviceToken = (id: string) =>
  useChange(
    (tokenId: string) => byHand.delete<void>(`/api/device-tokens/${tokenId}`),
    () => [keys.deviceTokens(id)],
  );
export const useConsent = (id: string) =>
  useChange(
    (input: Wire.ConsentIn) => byHand.put<unknown>(`/api/patients/${id}/consents`, input),
    () => [keys.consents(id)],
  );
export const useAddExercise = () =>
  useChange(
    (input: Wire.ExerciseIn) => byHand.post<Wire.Exercise>('/api/exercises', input),
    () => [keys.exercises],
  );
export const useChangeExercise = (id: string) =>
  useChange(
    (input: Wire.ExerciseChange) => byHand.patch<Wire.Exercise>(`/api/exercises/${id}`, input),
    () => [keys.exercises],
  );
export const useNewSession = (stored?: Stored) =>
  useChange(
    (input: Wire.SessionIn) => byHand.post<Wire.SessionDetail>('/api/sessions', input),
    (input) => [keys.patientSessions(input.patient_id), keys.caseload],
    [],
    stored,
  );
export const useDeleteSession = () =>
  useChange(
    (session: { id: string; patient_id: string }) => byHand.delete<void>(`/api/sessions/${session.id}`),
    (session) => [keys.patientSessions(session.patient_id), keys.caseload],
  );
export const useMoveSession = (session: { id: string; patient_id: string }) =>
  useChange(
    (input: Wire.SessionPatch) => byHand.patch<Wire.SessionDetail>(`/api/sessions/${session.id}`, input),
    () => [['sessions'], ['session'], ['patients'], keys.patientSessions(session.patient_id), keys.caseload],
  );
export const useMergePatients = (id: string) =>
  useChange(
    (input: Wire.MergeIn) => byHand.post<Wire.MergeOut>(`/api/patients/${id}/merge`, input),
    () => [['patients'], keys.caseload],
  );
export const useReprocess = (id: string) =>
  useChange(
    (input: Wire.ReprocessIn) => byHand.post<Wire.Job>(`/api/sessions/${id}/reprocess`, input),
    () => [keys.sessionJobs(id)],
  );
export const useReprocessAll = (id: string) =>
  useChange(
    () => byHand.post<Wire.Job[]>(`/api/sessions/${id}/reprocess-all`, {}),
    () => [keys.sessionJobs(id)],
  );
export const useCompare = (id: string) =>
  useChange(
    (input: { template_version_id: string; result_id?: string | null }) =>
      byHand.post<Wire.Comparison>(`/api/sessions/${id}/comparisons`, input),
    () => [keys.comparisons(id)],
  );
export const useSaveTemplate = () =>
  useChange(
    (input: Wire.TemplateIn) => byHand.post<Wire.TemplateVersionDetail>('/api/templates', input),
    () => [['templates']],
  );
/** What was drawn on a template, as its next version. */
export const useDrawVersion = (templateId: string, stored?: Stored) =>
  useChange(
    (input: Wire.TemplateVersionIn) =>
      byHand.post<Wire.TemplateVersionDetail>(`/api/templates/${templateId}/versions`, input),
    () => [['templates']],
    [],
    stored,
  );
/** Rename, tag, retire or restore a template. */
export const useChangeTemplate = (id: string) =>
  useChange(
    (input: Wire.TemplateChange) => byHand.patch<Wire.Template>(`/api/templates/${id}/entry`, input),
    () => [['templates']],
  );
/** Copy a version as a new template; without an exercise, for the other side. */
export const useCopyVersion = (versionId: string) =>
  useChange(
    (input: Wire.TemplateCopyIn) =>
      byHand.post<Wire.TemplateVersionDetail>(`/api/template-versions/${versionId}/copies`, input),
    () => [['templates'], keys.exercises],
  );

const NO_IMPLANTS = { patient_has_no_implant: true, people_nearby_have_none: true };
/** A session with a source, and the therapist's word about implants. Should the word be lost, its page asks again. */
export const useNewSourceSession = () =>
  useChange(
    async (input: Wire.SessionIn) => {
      const session = await byHand.post<Wire.SessionDetail>('/api/sessions', input);
      await byHand
        .post<Wire.MagneticSafety>(`/api/sessions/${session.id}/magnetic-safety`, NO_IMPLANTS)
        .catch(() => undefined);
      return session;
    },
    (input) => [keys.patientSessions(input.patient_id), keys.caseload],
  );
export const useMagneticSafety = (id: string, enabled: boolean) =>
  useGet<Wire.MagneticSafety>(keys.magneticSafety(id), `/api/sessions/${id}/magnetic-safety`, { enabled });
export const useConfirmNoImplants = (id: string) =>
  useChange(
    () => byHand.post<Wire.MagneticSafety>(`/api/sessions/${id}/magnetic-safety`, NO_IMPLANTS),
    () => [keys.magneticSafety(id), keys.session(id)],
  );
export const useWithdrawSafety = (id: string) =>
  useChange(
    () => byHand.delete<Wire.MagneticSafety>(`/api/sessions/${id}/magnetic-safety`),
    () => [keys.magneticSafety(id), keys.session(id)],
  );
export const useMagneticSources = (enabled: boolean) =>
  useGet<Wire.MagneticSource[]>(keys.magneticSources, '/api/magnetic-sources', { enabled });
export const useKeepSource = () =>
  useChange(
    (source: Wire.MagneticSourceIn) => byHand.post<Wire.MagneticSource>('/api/magnetic-sources', source),
    () => [keys.magneticSources],
  );
export const useRetireSource = () =>
  useChange(
    (id: string) => byHand.delete<void>(`/api/magnetic-sources/${id}`),
    () => [keys.magneticSources],
  );
export const useSourceStops = (id: string, enabled: boolean) =>
  useGet<Wire.SourceStops>(keys.sourceStops(id), `/api/sessions/${id}/source-stops`, { enabled, staleTime: Infinity });
export const useCalibrateSource = (id: string) =>
  useChange(
    (wanted: Wire.SourceCalibrationIn) =>
      byHand.post<Wire.MagneticSource>(`/api/sessions/${id}/source-calibration`, wanted),
    () => [keys.magneticSources],
  );
export const useSourceUse = (id: string, resultId: string | null) =>
  useGet<Wire.SourceUse>(
    keys.sourceUse(id, resultId),
    withQuery(`/api/sessions/${id}/source-use`, { result_id: resultId }),
    { staleTime: 60_000 },
  );
/** Curves over time by the names of their series, between commas. */
export const useSeries = (id: string, names: string, resultId: string | null) =>
  useGet<Wire.Series>(
    keys.series(id, names, resultId),
    withQuery(`/api/sessions/${id}/series`, { names, result_id: resultId, max_points: 1000 }),
    { staleTime: 60_000 },
  );
export const useGait = (id: string | null) =>
  useGet<Wire.Gait>(keys.gait(id ?? ''), `/api/sessions/${id}/gait`, {
    enabled: id !== null && id !== '',
    staleTime: 60_000,
  });
/** The strides of a walk that is too long for one answer. */
export const useStrides = (id: string, resultId: string, enabled: boolean) =>
  usePages<Wire.FootStride>(
    [...keys.gait(id), 'strides', resultId],
    withQuery(`/api/sessions/${id}/gait/strides`, { result_id: resultId, limit: 100 }),
    { enabled },
  );
export const useFootCurves = (id: string, resultId: string) =>
  useGet<Wire.FootCurves>(
    [...keys.gait(id), 'curves', resultId],
    `/api/sessions/${id}/gait/curves?result_id=${resultId}`,
    {
      staleTime: Infinity,
    },
  );
export const useWalks = (patientId: string) =>
  useAll<Wire.WalkRow>(keys.walks(patientId), `/api/patients/${patientId}/walks`, { enabled: patientId !== '' });
/** Two conditions compared; asked anew whenever the choice of walks changes. */
export const useConditions = (patientId: string, a: readonly string[], b: readonly string[]) =>
  useQuery({
    queryKey: keys.conditions(patientId, a, b),
    queryFn: () => api.post<Wire.Conditions>(`/api/patients/${patientId}/walks/comparison`, { a, b }),
    enabled: a.length > 0 && b.length > 0,
  });
