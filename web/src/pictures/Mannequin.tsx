// A drawn person for instructions: seen from the front or from the side, standing or seated, arms as asked for.
import type { ReactNode } from 'react';
import type { Limb } from '../lib/placements';
import './Mannequin.css';
import './pictures.css';

type Point = readonly [number, number];

/** Angles in degrees from hanging: of the upper arm and of the forearm, outward (front) or forward (side). */
export type Arm = readonly [upper: number, forearm: number];

const UPPER = 54;
const FOREARM = 48;
const HAND = 17;
const RADIANS = Math.PI / 180;

function along([x, y]: Point, degrees: number, length: number, sign: number): Point {
  return [x + sign * length * Math.sin(degrees * RADIANS), y + length * Math.cos(degrees * RADIANS)];
}

/** A limb that narrows: two round ends and what lies between. */
function limb(from: Point, to: Point, wide: number, narrow: number): string {
  const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
  const length = Math.hypot(dx, dy) || 1;
  const [nx, ny] = [-dy / length, dx / length];
  const at = (point: Point, by: number) => `${(point[0] + nx * by).toFixed(1)} ${(point[1] + ny * by).toFixed(1)}`;
  return `M${at(from, wide)}L${at(to, narrow)}A${narrow} ${narrow} 0 0 0 ${at(to, -narrow)}L${at(from, -wide)}A${wide} ${wide} 0 0 0 ${at(from, wide)}Z`;
}

export function armPoints(
  shoulder: Point,
  [upper, forearm]: Arm,
  sign: 1 | -1,
): { elbow: Point; wrist: Point; hand: Point } {
  const elbow = along(shoulder, upper, UPPER, sign);
  const wrist = along(elbow, forearm, FOREARM, sign);
  return { elbow, wrist, hand: along(wrist, forearm, HAND, sign) };
}

function ArmShape({
  shoulder,
  arm,
  sign,
  kind,
}: {
  shoulder: Point;
  arm: Arm;
  sign: 1 | -1;
  kind: 'rest' | 'moves' | 'before';
}) {
  const { elbow, wrist, hand } = armPoints(shoulder, arm, sign);
  return (
    <g className={`figure-${kind}`}>
      <path d={limb(shoulder, elbow, 10, 8)} />
      <path d={limb(elbow, wrist, 8, 5.5)} />
      <path d={limb(wrist, hand, 6, 4.5)} />
    </g>
  );
}

/** An arrow along a circle around a joint, from one angle to another. */
function Sweep({
  around,
  radius,
  from,
  to,
  sign,
}: {
  around: Point;
  radius: number;
  from: number;
  to: number;
  sign: 1 | -1;
}) {
  const start = along(around, from, radius, sign);
  const end = along(around, to, radius, sign);
  const isClockwise = sign * (to - from) < 0;
  const heading = along(end, to + (to > from ? 90 : -90), 1, sign);
  const [hx, hy] = [heading[0] - end[0], heading[1] - end[1]];
  const tip = `M${end[0] + 9 * hx} ${end[1] + 9 * hy}L${end[0] - 4 * hx - 6 * hy} ${end[1] - 4 * hy + 6 * hx}L${end[0] - 4 * hx + 6 * hy} ${end[1] - 4 * hy - 6 * hx}Z`;
  return (
    <g className="figure-arrow">
      <path d={`M${start.join(' ')}A${radius} ${radius} 0 0 ${isClockwise ? 1 : 0} ${end.join(' ')}`} />
      <path d={tip} className="figure-tip" />
    </g>
  );
}

export interface ManyArms {
  /** The arm at the end of the movement, or held. */
  arm: Arm;
  /** Where the movement begins; drawn faint, with an arrow from there. */
  before?: Arm;
  /** What turns: the whole arm, the forearm, or the forearm about its own axis. */
  turns?: 'shoulder' | 'elbow' | 'palm';
}

function Frame({ children, view = '0 0 240 306' }: { children: ReactNode; view?: string }) {
  return (
    <svg className="picture" viewBox={view} aria-hidden>
      {children}
    </svg>
  );
}

function Moves({
  shoulder,
  sign,
  arm,
  before,
  turns,
  kind = 'moves',
}: ManyArms & { shoulder: Point; sign: 1 | -1; kind?: 'rest' | 'moves' }) {
  const { elbow, wrist } = armPoints(shoulder, arm, sign);
  return (
    <>
      {before && <ArmShape shoulder={shoulder} arm={before} sign={sign} kind="before" />}
      <ArmShape shoulder={shoulder} arm={arm} sign={sign} kind={kind} />
      {before && turns === 'shoulder' && (
        <Sweep around={shoulder} radius={UPPER + 34} from={before[0] + 8} to={arm[0] - 14} sign={sign} />
      )}
      {before && turns === 'elbow' && (
        <Sweep around={elbow} radius={FOREARM + 28} from={before[1] + 8} to={arm[1] - 14} sign={sign} />
      )}
      {turns === 'palm' && (
        <g className="figure-arrow">
          <path d={`M${wrist[0] - 4} ${wrist[1] - 19}a7 19 0 1 1 -3 37`} />
          <path d={`M${wrist[0] - 13} ${wrist[1] + 16}l12 -4l-1 11Z`} className="figure-tip" />
        </g>
      )}
    </>
  );
}

function LegShape({
  hip,
  knee,
  ankle,
  isSeated,
  kind,
}: {
  hip: number;
  knee: Point;
  ankle: number;
  isSeated: boolean | undefined;
  kind: 'rest' | 'moves';
}) {
  return (
    <g className={`figure-${kind}`}>
      <path d={limb([hip, 168], knee, 15, isSeated ? 15 : 11)} />
      <path d={limb(knee, [ankle, 284], isSeated ? 13 : 11, 7)} />
      <path d={`M${ankle - 10} 292c0-6 5-8 10-8s10 3 10 8z`} />
    </g>
  );
}

const ARMS: readonly Limb[] = ['right_arm', 'left_arm'];

/**
 * Seen from the front, standing or on a stool; both arms do the same. `view` is the part of the drawing that is shown,
 * `stressed` are the limbs in colour.
 */
export function FrontFigure({
  isSeated,
  view = '-36 0 312 306',
  stressed = ARMS,
  ...arms
}: ManyArms & { isSeated?: boolean; view?: string; stressed?: readonly Limb[] }) {
  const knee = isSeated ? 204 : 230;
  const kind = (limb: Limb) => (stressed.includes(limb) ? 'moves' : 'rest');
  return (
    <Frame view={view}>
      <path className="figure-floor" d="M0 296h240" />
      {isSeated && <path className="figure-chair" d="M82 196h76M88 198v94M152 198v94" />}
      <LegShape hip={107} knee={[104, knee]} ankle={103} isSeated={isSeated} kind={kind('right_leg')} />
      <LegShape hip={133} knee={[136, knee]} ankle={137} isSeated={isSeated} kind={kind('left_leg')} />
      <g className="figure-rest">
        <path d="M112 58h16l2 12c10 2 20 5 24 12 4 8-4 34-8 54-2 12 0 22 2 34H92c2-12 4-22 2-34-4-20-12-46-8-54 4-7 14-10 24-12z" />
        <ellipse cx="120" cy="36" rx="17" ry="22" />
      </g>
      <Moves shoulder={[93, 84]} sign={-1} {...arms} kind={kind('right_arm')} />
      <Moves shoulder={[147, 84]} sign={1} {...arms} kind={kind('left_arm')} />
    </Frame>
  );
}

/** Seen from the side, facing right: standing, or seated on a chair with another person's hand on the arm. */
export function SideFigure({ isSeated, isHelped, ...arms }: ManyArms & { isSeated?: boolean; isHelped?: boolean }) {
  const shoulder: Point = isSeated ? [92, 116] : [104, 86];
  const { wrist } = armPoints(shoulder, arms.arm, 1);
  return (
    <Frame>
      <path className="figure-floor" d="M30 296h180" />
      {isSeated && <path className="figure-chair" d="M66 112v92h62M70 204v90M124 204v90" />}
      <g className="figure-rest">
        {isSeated ? (
          <>
            <path d={limb([90, 192], [148, 196], 15, 11)} />
            <path d={limb([148, 196], [146, 280], 11, 7)} />
            <path d="M140 292v-10h12c8 1 16 4 18 10z" />
            <path d="M84 96c10-6 20-2 22 8 4 18 4 36 2 54-2 16-2 30-4 46H78c-4-20-6-40-4-62 1-18 2-38 10-46z" />
            <path d="M88 80h16v22H86z" />
            <ellipse cx="98" cy="64" rx="18" ry="22" />
            <path d="M113 60l8 9-8 3z" />
          </>
        ) : (
          <>
            <path d={limb([104, 168], [107, 230], 16, 11)} />
            <path d={limb([107, 230], [104, 282], 11, 7)} />
            <path d="M97 292v-10h12c9 1 17 4 19 10z" />
            <path d="M94 66c12-6 22-1 25 10 4 18 4 34 1 52-2 15-1 32 0 44H90c-3-18-4-38-3-58 0-18-1-42 7-48z" />
            <path d="M100 52h15v20H98z" />
            <ellipse cx="110" cy="36" rx="18" ry="22" />
            <path d="M125 32l8 9-8 3z" />
          </>
        )}
      </g>
      <Moves shoulder={shoulder} sign={1} {...arms} />
      {isHelped && (
        <g className="figure-helper">
          <path d={limb([228, wrist[1] + 44], [wrist[0] + 8, wrist[1] + 6], 9, 6)} />
          <circle cx={wrist[0] + 3} cy={wrist[1] + 2} r="9" />
        </g>
      )}
    </Frame>
  );
}
