// A walking test while it happens: which kind, the clock of the recording, and what the feet have done so far.
import { t } from '../../i18n';
import type { Player } from '../../player/types';

export const WALK_KINDS = ['walk', 'timed_up_and_go', 'six_minute_walk'] as const;
export type WalkKind = (typeof WALK_KINDS)[number];
export const SIX_MINUTES_S = 360;
/** From the chair to the mark of a timed up and go. */
export const MARK_M = 3;

/** The test that an exercise is; everything else, and a free session, is a walk. */
export function walkKind(movement: string | undefined): WalkKind {
  return WALK_KINDS.find((kind) => kind === movement) ?? 'walk';
}

/** Minutes as `6:00`; a countdown shows the second that has begun. */
export function countdown(elapsedS: number): string {
  const left = Math.ceil(Math.max(0, SIX_MINUTES_S - elapsedS) - 1e-6);
  return `${Math.floor(left / 60)}:${String(left % 60).padStart(2, '0')}`;
}

/** What is to be said at this moment of a six-minute walk: each full minute, and the end. */
export function minutePrompt(elapsedS: number): string {
  if (elapsedS >= SIX_MINUTES_S) return t('guided.stopNow');
  const count = Math.floor(elapsedS / 60);
  return count > 0 ? t('guided.minutes', { count, left: 6 - count }) : '';
}

/**
 * Time of the session between the messages that tell it. It never runs back: the first message after a lost link, and
 * frames that are sent again, are older than now.
 */
export class SessionClock {
  #sessionS: number | null = null;
  #wallS = 0;
  readonly #now: () => number;

  constructor(now: () => number = () => performance.now() / 1000) {
    this.#now = now;
  }

  /** Take a time of the session that has just arrived; what was on its way longest is believed least. */
  set(sessionS: number): void {
    const shown = this.read();
    if (shown !== null && sessionS <= shown) return;
    this.#sessionS = sessionS;
    this.#wallS = this.#now();
  }

  /** Time of the session now; null before anything was set. */
  read(): number | null {
    return this.#sessionS === null ? null : this.#sessionS + this.#now() - this.#wallS;
  }
}

const SIDES = ['left', 'right'] as const;
/** A foot that was put down again nearer than this has not stepped on. */
const LEAST_M = 0.1;
/** Nearer to the start than this is back at the chair. */
const BACK_M = 0.7;

interface Foot {
  stands: boolean;
  start: readonly [number, number] | null;
  held: readonly [number, number] | null;
  wayM: number;
  awayM: number;
  steps: number;
}

export interface WalkSoFar {
  /** Way of the feet, mean of those that are worn; null before a foot was seen. */
  distanceM: number | null;
  steps: number;
  /** From where the feet stood at first. */
  awayM: number | null;
  /** Of a timed up and go. */
  leg: 'out' | 'turn' | 'back' | 'there';
}

/** Steps and way from the live frames since the recording began, or since the page was opened. */
export class WalkTally {
  readonly #fromS: number;
  readonly #feet: Record<(typeof SIDES)[number], Foot>;
  #readS: number;
  #farthestM = 0;
  #isBack = false;
  /** First moment that was counted; null before. */
  countedFromS: number | null = null;

  /** Frames before `fromS` are left out. */
  constructor(fromS: number) {
    this.#fromS = fromS;
    this.#readS = fromS;
    const foot = (): Foot => ({ stands: false, start: null, held: null, wayM: 0, awayM: NaN, steps: 0 });
    this.#feet = { left: foot(), right: foot() };
  }

  /** Take what is new. */
  take(player: Player): void {
    const { endS } = player.clock();
    if (!(endS > this.#readS)) return;
    const columns = SIDES.flatMap((side) => [`foot_${side}_stance`, `foot_${side}.x`, `foot_${side}.y`]);
    const found = player.read(this.#readS, endS, columns);
    this.#readS = endS;
    for (let row = 0; row < found.timeS.length; row += 1) {
      SIDES.forEach((side, index) => {
        const [stance, x, y] = [0, 1, 2].map((column) => found.values[3 * index + column]?.[row] ?? NaN) as [
          number,
          number,
          number,
        ];
        if (!Number.isFinite(stance + x + y)) return;
        this.countedFromS ??= found.timeS[row] ?? null;
        this.#step(this.#feet[side], stance > 0.5, [x, y]);
      });
      this.#follow();
    }
  }

  read(): WalkSoFar {
    const worn = SIDES.map((side) => this.#feet[side]).filter((foot) => foot.start !== null);
    const mean = (of: (foot: Foot) => number) =>
      worn.length ? worn.reduce((sum, foot) => sum + of(foot), 0) / worn.length : null;
    const awayM = mean((foot) => foot.awayM);
    const leg =
      this.#farthestM < MARK_M - 0.5 ? 'out' : !this.#isBack ? 'turn' : (awayM ?? Infinity) < BACK_M ? 'there' : 'back';
    return { distanceM: mean((foot) => foot.wayM), steps: worn.reduce((sum, foot) => sum + foot.steps, 0), awayM, leg };
  }

  get isWhole(): boolean {
    // The first second of a live walk is not shown yet when a recording begins with the stream.
    return this.countedFromS === null || this.countedFromS < this.#fromS + 2;
  }

  #step(foot: Foot, stands: boolean, place: readonly [number, number]): void {
    const far = (from: readonly [number, number]) => Math.hypot(place[0] - from[0], place[1] - from[1]);
    if (stands && !foot.stands) {
      foot.start ??= place;
      const wayM = foot.held === null ? 0 : far(foot.held);
      if (wayM >= LEAST_M) {
        foot.wayM += wayM;
        foot.steps += 1;
      }
      if (foot.held === null || wayM >= LEAST_M) foot.held = place;
    }
    foot.stands = stands;
    foot.awayM = foot.start === null ? NaN : far(foot.start);
  }

  #follow(): void {
    const away = SIDES.map((side) => this.#feet[side].awayM).filter(Number.isFinite);
    if (away.length === 0) return;
    const awayM = away.reduce((sum, one) => sum + one, 0) / away.length;
    this.#farthestM = Math.max(this.#farthestM, awayM);
    if (this.#farthestM >= MARK_M - 0.5 && awayM < this.#farthestM - 0.5) this.#isBack = true;
  }
}
