// What a flat figure draws of the frames of a session: points of the room (x forward, y left, z up), seen along an axis.
import type { LayoutMessage } from '../../api/types';

export type FlatView = 'front' | 'left' | 'right' | 'above';
/** A place in the room, m. */
export type Place = readonly [number, number, number];

export interface Bone {
  from: string;
  to: string;
  /** The segment has a sensor; others follow their neighbours and are drawn pale. */
  isMeasured: boolean;
}

export interface FlatScene {
  views: readonly [FlatView, FlatView];
  /** Names of the points; each is three columns. */
  points: readonly string[];
  /** Empty where the points are feet or modules, which are drawn as dots with their names. */
  bones: readonly Bone[];
  /** Half of the width and height of a picture, m. */
  half: number;
}

/** From, to, and the segment whose sensor moves it. */
const BODY: readonly (readonly [string, string, string])[] = [
  ['pelvis', 'neck', 'sternum'],
  ['neck', 'head', 'head'],
  ...['left', 'right'].flatMap((side) => [
    ['neck', `shoulder_${side}`, 'sternum'] as const,
    [`shoulder_${side}`, `elbow_${side}`, `upper_arm_${side}`] as const,
    [`elbow_${side}`, `wrist_${side}`, `forearm_${side}`] as const,
    [`wrist_${side}`, `hand_${side}`, `hand_${side}`] as const,
  ]),
];
/** From a hand that hangs to one that is raised: this far around a middle above the pelvis. */
const BODY_HALF_M = 0.8;
const MIDDLE_M = 0.47;
const FEET_HALF_M = 0.8;
const MODULES_HALF_M = 0.5;

/** Nothing where the frames hold no positions: of single sensors, and of legs alone. */
export function sceneOf({ points, segments }: LayoutMessage['layout']): FlatScene | null {
  const bones = BODY.filter(([from, to]) => points.includes(from) && points.includes(to)).map(
    ([from, to, segment]) => ({
      from,
      to,
      isMeasured: segments.includes(segment),
    }),
  );
  if (bones.length > 0) {
    const isLeft = bones.some((one) => one.isMeasured && one.to === 'elbow_left');
    const isRight = bones.some((one) => one.isMeasured && one.to === 'elbow_right');
    return { views: ['front', isLeft && !isRight ? 'left' : 'right'], points, bones, half: BODY_HALF_M };
  }
  const places = points.filter((name) => segments.includes(name));
  if (places.length < 2) return null;
  const areFeet = places.every((name) => name.startsWith('foot_'));
  return {
    views: areFeet ? ['above', 'right'] : ['front', 'right'],
    points: places,
    bones: [],
    half: areFeet ? FEET_HALF_M : MODULES_HALF_M,
  };
}

/** Where a place stands in the picture, m to the right and m down. */
export function seen([x, y, z]: Place, view: FlatView): readonly [number, number] {
  if (view === 'above') return [-y, -x];
  // Who stands before the patient has the patient's left at the right hand.
  return [view === 'front' ? y : view === 'right' ? x : -x, -z];
}

/** What stands in the middle of the picture: a place above the pelvis, or the mean of what is there. */
export function middleOf(scene: FlatScene, at: ReadonlyMap<string, Place>): Place {
  const pelvis = at.get('pelvis');
  if (scene.bones.length > 0 && pelvis) return [pelvis[0], pelvis[1], pelvis[2] + MIDDLE_M];
  const all = [...at.values()];
  const mean = (axis: 0 | 1 | 2) => all.reduce((sum, one) => sum + one[axis], 0) / (all.length || 1);
  return [mean(0), mean(1), mean(2)];
}
