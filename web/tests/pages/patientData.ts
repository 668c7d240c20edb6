// A patient's record as the service answers it, for walking through the patient's own pages.
import { changed } from '../trend';
import { PROTOCOL_VERSION } from '../../src/api/schema';
import type {
  AuditEntry,
  CalibrationMessage,
  Comparison,
  Exercise,
  GuidanceMessage,
  HealthMessage,
  LayoutMessage,
  LiveMessage,
  Me,
  MeasureValue,
  Prescription,
  Progress,
  Session,
  SessionDetail,
  SessionState,
  StateMessage,
} from '../../src/api/types';
import { words as en } from '../../src/i18n/en';
import { THERAPIST } from './render';

export const PATIENT: Me = {
  ...THERAPIST,
  account_id: 'pa',
  display_name: 'Amara Okafor',
  email: 'amara@example.org',
  role: 'patient',
  patient_id: 'p',
};

const ANGLE = 'humerus_forearm_right_zxy_flexion';
const exercise = {
  id: 'e',
  name: 'Reach forward',
  description: 'Reach for the cup.',
  movement: 'reaching',
  primary_angle: ANGLE,
  side: 'right',
  created_at: '2026-11-01T10:00:00Z',
} as unknown as Exercise;
const prescription = {
  id: 'pr',
  patient_id: 'p',
  exercise_id: 'e',
  exercise_name: 'Reach forward',
  sets: 2,
  repetitions: 10,
  times_per_week: 3,
  done_this_week: 1,
  template_id: 't',
} as unknown as Prescription;

export function session(change: Partial<Session>): Session {
  return {
    id: 's',
    patient_id: 'p',
    exercise_id: 'e',
    exercise_name: 'Reach forward',
    prescription_id: 'pr',
    purpose: 'exercise',
    source: 'stream',
    state: 'analysed',
    state_reason: 'The estimator madgwick did not converge: residual 4 %.',
    created_at: '2026-11-20T09:00:00Z',
    started_at: '2026-11-20T09:01:00Z',
    ended_at: '2026-11-20T09:05:00Z',
    duration_s: 240,
    packets_stored: 2400,
    packets_missing: 3,
    main_result_id: 'r',
    ...change,
  } as Session;
}

const layout = {
  segments: ['thorax', 'humerus_right', 'forearm_right'],
  points: [],
  angles: [ANGLE],
  scalars: ['humerus_forearm_right_heading_sigma_rad'],
};
const calibration = {
  method: 'n_pose',
  score: 87,
  reasons: ['Sigma of the heading is 2°.'],
  needs_headings: false,
  sentences: {},
} as unknown as SessionDetail['calibration'];

export function detail(change: Partial<SessionDetail>): SessionDetail {
  return {
    ...session({}),
    pipeline: 'upper_body',
    placements: ['sternum', 'upper_arm_right', 'forearm_right'],
    rate_hz: 100,
    orientation: 'madgwick',
    orientation_parameters: {},
    constrain_joint_headings: true,
    calibration,
    recording_start_s: 5,
    recording_end_s: 200,
    results: [{ id: 'r', status: 'complete', orientation: 'madgwick' }] as unknown as SessionDetail['results'],
    events: [
      { kind: 'gap', time_s: 4, duration_s: 0.2, placement: 'sternum', text: '12 packets missing.' },
    ] as unknown as SessionDetail['events'],
    layout,
    may_treat: false,
    ...change,
  } as SessionDetail;
}

const measure = (name: string, value: number, template: number | null, unit = 'deg') =>
  ({
    measure: name,
    label: 'Elbow flexion, range of motion',
    value,
    unit,
    uncertainty: 0.4,
    count: 10,
    template_value: template,
    group: 'range',
  }) as MeasureValue;
const comparison = {
  id: 'c',
  session_id: 's',
  result_id: 'r',
  template_version_id: 'tv',
  template_name: 'Reach, therapist 2',
  created_at: '2026-11-20T09:06:00Z',
  repetition_count: 10,
  summary: [
    measure(`range:${ANGLE}`, 59, 66),
    measure('sparc', -1.7, -1.5, '1'),
    measure('inside_band', 80, null, '%'),
  ],
} as unknown as Comparison;

const point = (session_id: string, value: number) => ({
  session_id,
  at: '2026-11-20T09:00:00Z',
  value,
  low: value - 2,
  high: value + 2,
  count: 10,
  orientation: 'madgwick',
  template_version_id: 'tv',
});
const progress = {
  exercise_id: 'e',
  measures: [
    {
      measure: `range:${ANGLE}`,
      label: 'Elbow flexion, range of motion',
      unit: 'deg',
      points: [point('x', 50), point('y', 51), point('z', 52), point('s', 59)],
      trend: changed(50, 58, 3),
    },
  ],
  events: [],
} as unknown as Progress;

/** Everything anybody can have done with a record. */
const audit = Object.keys(en)
  .filter((key) => key.startsWith('audit.') && key !== 'audit.open' && key !== 'audit.none' && key !== 'audit.times')
  .map((key, index) => ({
    id: String(index),
    at: '2026-11-20T09:00:00Z',
    who: 'Ingrid Solberg',
    role: 'therapist',
    action: key.slice('audit.'.length),
  })) as unknown as AuditEntry[];

/** Answers to what the pages ask, for a session in a state. */
export function answers(
  change: Partial<SessionDetail> = {},
  ofExercise: Partial<Exercise> = {},
): Record<string, unknown> {
  const own = detail(change);
  const sessions = [
    session(own),
    session({ id: 'o', started_at: '2026-11-20T15:00:00Z' }),
    session({ id: 'n', exercise_id: null, exercise_name: null, started_at: '2026-11-18T15:00:00Z', duration_s: 40 }),
  ];
  return {
    '/api/me': PATIENT,
    '/api/me/second-factor': { is_on: false, since: null, recovery_codes_left: 0 },
    '/api/patients/p': {
      id: 'p',
      given_name: 'Amara',
      family_name: 'Okafor',
      affected_side: 'right',
      may_manage: false,
      archived_at: null,
    },
    '/api/patients/p/prescriptions': [prescription],
    '/api/patients/p/sessions': sessions,
    '/api/patients/p/progress': progress,
    '/api/patients/p/progress?exercise_id=e': progress,
    '/api/patients/p/grants': [{ id: 'g', display_name: 'Ingrid Solberg', level: 'treat' }],
    '/api/patients/p/consents': [{ purpose: 'home_streaming', granted: true, changed_at: '2026-11-01T10:00:00Z' }],
    '/api/patients/p/audit': audit,
    '/api/exercises': [{ ...exercise, ...ofExercise }],
    '/api/sessions/s': own,
    '/api/sessions/s/comparisons': [comparison],
    'POST /api/sessions/s/views': [503, { code: 'unavailable', message: 'Too many 3D views are open.', details: {} }],
    'POST /api/sessions/s/calibration/start': [
      409,
      { code: 'conflict', message: 'A calibration is running: collecting the N-pose.', details: {} },
    ],
  };
}

export const layoutMessage = {
  type: 'layout',
  protocol_version: PROTOCOL_VERSION,
  layout,
  columns: [ANGLE],
  rate_hz: 100,
  delay_s: 0.4,
} as unknown as LayoutMessage;
export const guidance = (change: Partial<GuidanceMessage> = {}): GuidanceMessage => ({
  sentences: {},
  type: 'guidance',
  status: 'ready',
  cause: '',
  time_s: 12,
  phase: null,
  sigma: null,
  ghost_phase: 0,
  counts: { valid: 2, partial: 1, wrong: 0 },
  goal: 10,
  before: 0,
  last: 'valid',
  cue: '',
  cue_number: 0,
  ...change,
});

export const health: HealthMessage = {
  type: 'health',
  sensors: [
    {
      placement: 'sternum',
      status: 'ok',
      loss_percent: 0.2,
      jitter_ms: 90,
      saturated: true,
      magnetic_disturbance: true,
      heading_trusted: false,
      battery_percent: 9,
    },
    {
      placement: 'forearm_right',
      status: 'lost',
      loss_percent: 40,
      jitter_ms: 3,
      saturated: false,
      magnetic_disturbance: false,
      heading_trusted: true,
      battery_percent: null,
    },
  ],
  packets_received: 100,
  packets_stored: 100,
  is_being_stored: true,
  packets_missing: 4,
  latency_ms_median: 12,
  latency_ms_p99: 40,
  clock_skew_ppm: 3,
};
export const stateMessage = (state: SessionState, change: Partial<StateMessage> = {}): LiveMessage =>
  ({
    type: 'state',
    state,
    reason: 'The gateway went away.',
    session_time_s: 10,
    recording_start_s: null,
    calibration,
    calibration_progress: null,
    calibration_hint: 'Hold the N-pose.',
    sentences: {},
    ...change,
  }) as unknown as LiveMessage;
export const guide = (phase: CalibrationMessage['phase']): LiveMessage =>
  ({
    type: 'calibration',
    kind: 'n_pose',
    phase,
    step: 0,
    step_progress: 0.4,
    hint: 'The gyroscope of the forearm moved by 4 °/s.',
    steps: [
      { key: 'pose', title: 'Hold the N-pose', instruction: 'Hold the N-pose.', picture: 'n_pose', ends: 'itself' },
    ],
    sensors: [],
    score: 41,
    reasons: ['Axis uncertainty 9°.'],
  }) as unknown as LiveMessage;
