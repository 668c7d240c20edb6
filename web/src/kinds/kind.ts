// What a kind of session shows that others do not. No page asks which kind a session is: it shows what the kind gives.
import type { ComponentType } from 'react';
import type {
  Exercise,
  Patient,
  Placement,
  SessionDetail,
  SessionIn,
  SessionState,
  Side,
  StateMessage,
} from '../api/types';
import type { TemplateAt } from '../charts/Traces';
import type { Near } from '../components/CameraBar';
import type { LivePlayer } from '../player/live';
import type { ReplayPlayer } from '../player/replay';
import type { Columns } from '../player/types';

export interface LiveProps {
  session: SessionDetail;
  player: LivePlayer;
  /** The newest word of the service on the state, null before the first. */
  message: StateMessage | null;
  state: SessionState;
  columns: Columns | null;
  /** Null while it is not known yet. */
  exercise: Exercise | null | undefined;
  isRecording: boolean;
  mayRecord: boolean;
}

export interface ReplayProps {
  session: SessionDetail;
  player: ReplayPlayer;
  resultId: string;
  /** Go to a moment, in seconds since the start of what is shown. */
  onSeek: (sinceStartS: number) => void;
}

export interface CurvesProps extends ReplayProps {
  /** The template over time; undefined without a comparison. */
  templateAt: TemplateAt | undefined;
  /** The channels that were compared. */
  compared: readonly string[];
}

/** What was asked of every new session before the questions of its kind. */
export interface BeginProps {
  patient: Patient;
  pipeline: NonNullable<SessionIn['pipeline']>;
  purpose: NonNullable<SessionIn['purpose']>;
  /** The exercise with its prescription. */
  exercise: Pick<SessionIn, 'exercise_id' | 'prescription_id'>;
  /** The joint angle that counts in the exercise. */
  angle: string | undefined;
}

type Part<Props> = ComponentType<Props>;

export interface SessionKind {
  /** The name the service gives it. */
  pipeline: string;
  /** Its place in lists of kinds. */
  rank: number;
  /** What a session without an exercise is called. */
  free: () => string;
  /** What the nearest point of view shows. */
  near: Near;
  /** Angles mean nothing before a pose or movements were evaluated. */
  needsPose: boolean;
  /** A protocol of its own leads through the recording. */
  isGuided: boolean;
  /** Other orientation estimators can be tried on a stored session. */
  hasEstimators: boolean;
  /** Repetitions are compared with a template; of a walk its strides are. */
  isCompared: boolean;
  /** How it is offered for a new session. */
  begin?: {
    title: () => string;
    text: () => string;
    /** Whether a therapist can record a template of it. */
    isTemplate: boolean;
    /** It is no exercise. */
    isApart?: boolean;
    /** The exercises that are done with it. */
    suits?: (movement: string | undefined) => boolean;
    /** What is worn where nobody is asked: at home; for the side, and the angle that counts. */
    usual?: (side: Side | null | undefined, angle?: string) => Placement[];
    /** What can be worn, where that is all there is to choose; otherwise the kind has a form of its own. */
    worn?: readonly { title: () => string; placements: readonly Placement[] }[];
  };
  /** How it is offered for a file whose format does not say what it holds. */
  upload?: { title: () => string; text: () => string };
  /** Its sensors are on segments of a body. */
  hasPlaces: boolean;
  /** How far apart the feet stood at the start has to be said. */
  asksFeetApart: boolean;
  /** What `telemotion simulate` needs besides, to try such a session. */
  simulated?: (session: SessionDetail) => string;
}

/** Its components; apart, so that a page that asks for a word does not load them. */
export interface KindPanels {
  /** Its questions for a new session, inside a `BeginForm`. */
  Begin?: Part<BeginProps>;
  live: {
    /** Before anything is connected. */
    First?: Part<LiveProps>;
    /** From the first packet on: above the buttons, under them, under the picture, and at the side. */
    Guide?: Part<LiveProps>;
    Start?: Part<LiveProps>;
    Curves?: Part<LiveProps>;
    Side?: Part<LiveProps>;
  };
  /** The sheets of its report; without, those of joint angles. */
  Report?: Part<{ session: SessionDetail; patient: Patient }>;
  replay: {
    UnderPicture?: Part<{ session: SessionDetail }>;
    /** A tab of its own, which opens first. */
    tab?: { value: string; title: () => string; Panel: Part<ReplayProps> };
    /** The title of the tab of angles; without, there is none. */
    angles?: () => string;
    /** What that tab shows instead of the joint angles of the frames. */
    Curves?: Part<CurvesProps>;
    /** Replaces the buttons at the head of an analysed session. */
    Actions?: Part<{ session: SessionDetail }>;
  };
}
