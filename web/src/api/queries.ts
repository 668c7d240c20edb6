// Every question the client asks the service. What the service is asked to change is in `changes.ts`.
import {
  infiniteQueryOptions,
  queryOptions,
  useInfiniteQuery,
  useMutation,
  useQuery,
  useQueryClient,
  type QueryClient,
} from '@tanstack/react-query';
import { address, key, keyOf, ofPatient, ofSession, type Given, type PathOf } from './address';
import { api, ApiError, setCsrfToken } from './client';
import type * as Wire from './types';
import { speakLanguage, wanted } from '../i18n/languages';
import { forgetDrafts, forgetDraftsOfOthers } from '../lib/editing/drafts';
import { releaseAll } from '../lib/editing/unsaved';
import { holdStoreKey } from '../sensors/gateway/seal';
import { stopMeasuring } from '../sensors/registry';

/** Take over who has signed in: the token of changes, and the language. */
export async function acceptMe(me: Wire.Me): Promise<Wire.Me> {
  setCsrfToken(me.csrf_token, me.account_id);
  holdStoreKey(me.store_key);
  await speakLanguage(wanted(me.locale));
  return me;
}

/** Who is signed in; null when nobody is. */
export const meQuery = queryOptions({
  queryKey: key('me'),
  queryFn: async ({ signal }): Promise<Wire.Me | null> => {
    try {
      return await acceptMe(await api.get(address('/api/me'), signal));
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
    mutationFn: async (body: Wire.SignInRequest) => acceptMe(await api.post('/api/sign-in', { body })),
    onSuccess: (me) => {
      stopMeasuring();
      forgetDraftsOfOthers(me.account_id);
      client.clear();
      client.setQueryData(key('me'), me);
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
  client.setQueryData(key('me'), null);
}

/** One question, for `useQuery`; its key is its address, so a change names the addresses that it makes old. */
export function question<P extends PathOf<'get'>>(path: P, ...given: Given<'get', P>) {
  const at = address(path, ...given);
  return queryOptions({ queryKey: keyOf(at), queryFn: ({ signal }) => api.get(at, signal) });
}

/** A list of which every row is needed. */
function whole<P extends PathOf<'get'>>(path: P, ...given: Given<'get', P>) {
  const at = address(path, ...given);
  return queryOptions({ queryKey: keyOf(at), queryFn: ({ signal }) => api.all(at, signal) });
}

/** The same function for every render: another one would join the pages again each time. */
const rowsOf = <Row>(data: { pages: readonly { rows: readonly Row[] }[] }): Row[] =>
  data.pages.flatMap((page) => page.rows);

/** A list that people read: its first page, and further ones when they ask (`ShowMore`). */
function pages<P extends PathOf<'get'>>(path: P, ...given: Given<'get', P>) {
  const at = address(path, ...given);
  return infiniteQueryOptions({
    queryKey: [...keyOf(at), 'pages'],
    queryFn: ({ pageParam, signal }) => api.page(pageParam, signal),
    initialPageParam: at,
    getNextPageParam: (last) => last.next,
    select: rowsOf,
  });
}

/** How far the past sessions of the demonstration are; null elsewhere, and nobody asks again then. */
export const useDemonstration = () =>
  useQuery({
    ...question('/api/demonstration'),
    refetchInterval: (query) => (query.state.data ? 3_000 : false),
    staleTime: Infinity,
  });
export const useCaseload = () => useInfiniteQuery({ ...pages('/api/caseload'), refetchInterval: 15_000 });
export const usePatients = () => useQuery(whole('/api/patients'));
export const useArchivedPatients = () => useInfiniteQuery(pages('/api/patients', { query: { archived: true } }));
export const usePatient = (id: string) =>
  useQuery({ ...question('/api/patients/{patient_id}', ofPatient(id)), enabled: id !== '' });
/** With `until`, a session, as it was known with that one. */
export const useProgress = (id: string, exercise_id: string | null, until: string | null = null) =>
  useQuery(question('/api/patients/{patient_id}/progress', { ...ofPatient(id), query: { exercise_id, until } }));
export const useAnswers = (id: string, enabled = true) =>
  useQuery({ ...question('/api/sessions/{session_id}/answers', ofSession(id)), enabled });
export const useCourse = (id: string, exerciseId: string | null) =>
  useQuery({
    ...question('/api/patients/{patient_id}/course', { ...ofPatient(id), query: { exercise_id: exerciseId ?? '' } }),
    enabled: exerciseId !== null,
  });
/** What happened in a patient's sessions that a therapist must have seen, seen or not; the newest first. */
export const usePatientWorries = (id: string) => useQuery(whole('/api/patients/{patient_id}/worries', ofPatient(id)));
/** Version of the software that answers. */
export const useVersion = () => useQuery(question('/api/health'));
export const usePatientSessions = (id: string, enabled = true) =>
  useInfiniteQuery({
    ...pages('/api/patients/{patient_id}/sessions', ofPatient(id)),
    enabled: enabled && id !== '',
  });
export const usePrescriptions = (id: string) =>
  useQuery({ ...question('/api/patients/{patient_id}/prescriptions', ofPatient(id)), enabled: id !== '' });
export const useGrants = (id: string, enabled = true) =>
  useQuery({ ...question('/api/patients/{patient_id}/grants', ofPatient(id)), enabled });
export const useDeviceTokens = (id: string, enabled = true) =>
  useQuery({ ...whole('/api/patients/{patient_id}/device-tokens', ofPatient(id)), enabled });
export const useConsents = (id: string) => useQuery(question('/api/patients/{patient_id}/consents', ofPatient(id)));
export const useAudit = (id: string, enabled = true) =>
  useInfiniteQuery({ ...pages('/api/patients/{patient_id}/audit', ofPatient(id)), enabled });
export const useAccounts = (enabled = true) => useQuery({ ...whole('/api/accounts'), enabled });
export const useClinic = () => useQuery(question('/api/clinic'));
export const useSecondFactor = () => useQuery(question('/api/me/second-factor'));
export const useExercises = () => useQuery({ ...question('/api/exercises'), staleTime: 60_000 });
export const useTemplates = (
  exercise_id: string | null,
  patient_id: string | null,
  enabled = true,
  withRetired = false,
) =>
  useQuery({
    ...whole('/api/templates', { query: { exercise_id, patient_id, is_retired: withRetired || undefined } }),
    enabled,
  });
/** Templates of the clinic whose name, exercise or tags hold all the words. */
export const useTemplateSearch = (words: string, withRetired: boolean) =>
  useInfiniteQuery(pages('/api/templates', { query: { words, is_retired: withRetired || undefined } }));
export const useTemplateVersion = (id: string | null) =>
  useQuery({
    ...question('/api/template-versions/{version_id}', { path: { version_id: id ?? '' } }),
    enabled: id !== null,
    staleTime: Infinity,
  });
export const useSession = (id: string, refetchInterval?: number) =>
  useQuery({ ...question('/api/sessions/{session_id}', ofSession(id)), enabled: id !== '', refetchInterval });
/** The newest tasks: a page holds more than a session has at once. */
export const useSessionJobs = (id: string, refetchInterval?: number) =>
  useQuery({ ...question('/api/sessions/{session_id}/jobs', ofSession(id)), enabled: id !== '', refetchInterval });
export const useMarkers = (id: string) => useQuery(whole('/api/sessions/{session_id}/markers', ofSession(id)));
/** Fused motion in blocks of so many seconds, so that a long session is fetched as it is looked at. */
export const MOTION_BLOCK_S = 20;
export const useMarkerMotion = (id: string, markers_id: string, block: number) =>
  useQuery({
    ...question('/api/sessions/{session_id}/markers/motion/stretch', {
      ...ofSession(id),
      query: { markers_id, from_s: block * MOTION_BLOCK_S, until_s: (block + 1) * MOTION_BLOCK_S },
    }),
    staleTime: Infinity,
  });
export const useComparisons = (id: string) => useQuery(whole('/api/sessions/{session_id}/comparisons', ofSession(id)));
export const useComparison = (id: string | null) =>
  useQuery({
    ...question('/api/comparisons/{comparison_id}', { path: { comparison_id: id ?? '' } }),
    enabled: id !== null,
    staleTime: Infinity,
  });
export const useEstimators = () => useQuery({ ...question('/api/estimators'), staleTime: Infinity });
export const useFormats = () => useQuery({ ...question('/api/uploads/formats'), staleTime: Infinity });
export const useCalibrations = (enabled = true) =>
  useQuery({ ...question('/api/calibrations'), staleTime: Infinity, enabled });
export const useAccuracy = () => useQuery({ ...question('/api/accuracy'), staleTime: Infinity });

/** A long task, asked for twice a second until it ends. */
export function useJob(id: string | null, onEnd?: (job: Wire.Job) => void) {
  const client = useQueryClient();
  const at = address('/api/jobs/{job_id}', { path: { job_id: id ?? '' } });
  return useQuery({
    queryKey: keyOf(at),
    enabled: id !== null,
    queryFn: async ({ signal }) => {
      const job = await api.get(at, signal);
      if (job.status === 'complete' || job.status === 'failed') {
        await client.invalidateQueries({ queryKey: key('sessions', job.session_id) });
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

export const useMagneticSafety = (id: string, enabled: boolean) =>
  useQuery({ ...question('/api/sessions/{session_id}/magnetic-safety', ofSession(id)), enabled });
export const useMagneticSources = (enabled: boolean) => useQuery({ ...question('/api/magnetic-sources'), enabled });
export const useSourceStops = (id: string, enabled: boolean) =>
  useQuery({ ...question('/api/sessions/{session_id}/source-stops', ofSession(id)), enabled, staleTime: Infinity });
export const useSourceUse = (id: string, result_id: string | null) =>
  useQuery({
    ...question('/api/sessions/{session_id}/source-use', { ...ofSession(id), query: { result_id } }),
    staleTime: 60_000,
  });
/** Curves over time by the names of their series, between commas. */
export const useSeries = (id: string, names: string, result_id: string | null) =>
  useQuery({
    ...question('/api/sessions/{session_id}/series', {
      ...ofSession(id),
      query: { names, result_id, max_points: 1000 },
    }),
    staleTime: 60_000,
  });
export const useGait = (id: string | null) =>
  useQuery({ ...question('/api/sessions/{session_id}/gait', ofSession(id ?? '')), enabled: !!id, staleTime: 60_000 });
/** The strides of a walk that is too long for one answer. */
export const useStrides = (id: string, result_id: string, enabled: boolean) =>
  useInfiniteQuery({
    ...pages('/api/sessions/{session_id}/gait/strides', { ...ofSession(id), query: { result_id, limit: 100 } }),
    enabled,
  });
export const useFootCurves = (id: string, result_id: string) =>
  useQuery({
    ...question('/api/sessions/{session_id}/gait/curves', { ...ofSession(id), query: { result_id } }),
    staleTime: Infinity,
  });
export const useWalks = (id: string) =>
  useQuery({ ...whole('/api/patients/{patient_id}/walks', ofPatient(id)), enabled: id !== '' });
/** Two conditions compared; asked anew whenever the choice of walks changes. */
export const useConditions = (id: string, a: string[], b: string[]) =>
  useQuery({
    queryKey: [...key('patients', id, 'walks', 'comparison'), a, b],
    queryFn: () => api.post('/api/patients/{patient_id}/walks/comparison', { ...ofPatient(id), body: { a, b } }),
    enabled: a.length > 0 && b.length > 0,
  });
