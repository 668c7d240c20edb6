// What a kind of session shows that others do not. No page asks which kind a session is: it shows what the kind gives.
import type { ComponentType } from 'react';
import type { Exercise, Patient, Placement, SessionDetail, SessionState, StateMessage } from '../api/types';
import type { Near } from '../components/Viewer3D';
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

type Part<Props> = ComponentType<Props>;

export interface SessionKind {
  /** The name the service gives it. */
  pipeline: string;
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
  /** Repetitions are compared with a template. */
  isCompared: boolean;
  /** How it is offered for a new session, where nothing more is to be said than which sensors are worn. */
  begin?: {
    title: () => string;
    text: () => string;
    worn: readonly { title: () => string; placements: readonly Placement[] }[];
  };
  /** What `telemotion simulate` needs besides, to try such a session. */
  simulated?: (session: SessionDetail) => string;
}

/** Its components; apart, so that a page that asks for a word does not load them. */
export interface KindParts {
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
    /** Replaces the buttons at the head of an analysed session. */
    Actions?: Part<{ session: SessionDetail }>;
  };
}
