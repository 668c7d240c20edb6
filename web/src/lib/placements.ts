import type { Placement, Side, SessionDetail } from '../api/types';

/** What to wear for a walk. */
export const FEET: Placement[] = ['foot_left', 'foot_right'];

/** How the angles of a leg begin: hip, knee and ankle. */
export const LEG_JOINTS = ['pelvis_thigh', 'thigh_shank', 'shank_foot'] as const;
const LEG_ANGLE = new RegExp(`^(?:${LEG_JOINTS.join('|')})_(left|right)_`);

/** Which limb an angle is of; `foot`: of a foot that walks. */
export function limbOf(angle: string | undefined): 'arm' | 'leg' | 'foot' {
  if (angle?.startsWith('foot_')) return 'foot';
  return LEG_ANGLE.test(angle ?? '') ? 'leg' : 'arm';
}

/** Sensors of one arm, from the shoulder outwards. */
export function armPlacements(side: 'left' | 'right'): Placement[] {
  return [`upper_arm_${side}`, `forearm_${side}`, `hand_${side}`];
}

/**
 * What to wear for a side: the chest for the trunk, then the arm or both arms; where the angle that counts is one of a
 * leg, the pelvis and that leg.
 */
export function suggestedPlacements(side: Side | null | undefined, angle = ''): Placement[] {
  const leg = LEG_ANGLE.exec(angle)?.[1];
  if (leg) return ['sternum', 'pelvis', ...legPlacements(leg === 'left' ? 'left' : 'right')];
  if (side === 'both') return ['sternum', ...armPlacements('left'), ...armPlacements('right')];
  return ['sternum', ...armPlacements(side === 'left' ? 'left' : 'right')];
}

/** Sensors of one leg, from the hip down. */
export function legPlacements(side: 'left' | 'right'): Placement[] {
  return [`thigh_${side}`, `shank_${side}`, `foot_${side}`];
}

export type Limb = 'right_arm' | 'left_arm' | 'right_leg' | 'left_leg';

/** The limbs that carry sensors: the only ones that a picture colours. */
export function wornLimbs(placements: readonly string[]): Limb[] {
  const carries = (some: readonly Placement[]) => some.some((one) => placements.includes(one));
  return (['right', 'left'] as const).flatMap((side): Limb[] => [
    ...(carries(armPlacements(side)) ? [`${side}_arm` as const] : []),
    ...(carries(legPlacements(side)) ? [`${side}_leg` as const] : []),
  ]);
}

/** Sensors on the legs: hips, knees and ankles; with both thighs and the trunk the centre of mass. */
export const LEG_PLACEMENTS: Placement[] = [...legPlacements('left'), ...legPlacements('right')];

/** Whether legs are measured and no arm is. */
export function isOfLegs(placements: readonly string[]): boolean {
  const has = (some: readonly string[]) => some.some((one) => placements.includes(one));
  return has(LEG_PLACEMENTS) && !has([...armPlacements('left'), ...armPlacements('right')]);
}

/** Whether a hip, a knee or an ankle has a sensor above and below it. */
function tellsLeg(placements: readonly Placement[]): boolean {
  return (['left', 'right'] as const).some((side) => {
    const worn = ['pelvis' as const, ...legPlacements(side)].map((placement) => placements.includes(placement));
    return worn.some((is, index) => is && worn[index + 1]);
  });
}

/** Whether the sensors tell the centre of mass of the body: one on the trunk and both thighs. */
export function tellsMassCentre(placements: readonly Placement[]): boolean {
  const has = (placement: Placement) => placements.includes(placement);
  return has('thigh_left') && has('thigh_right') && (has('sternum') || has('pelvis'));
}

/** What is missing, as a key of the catalogue; null when the choice makes sense. */
export function placementProblem(
  placements: readonly Placement[],
): 'placements.needUpperArm' | 'placements.needForearm' | 'placements.needArm' | 'placements.needLegs' | null {
  const has = (placement: Placement) => placements.includes(placement);
  const hasLegs = tellsLeg(placements) || tellsMassCentre(placements);
  if (LEG_PLACEMENTS.some(has) && !hasLegs) return 'placements.needLegs';
  const arms = (['left', 'right'] as const).filter((side) => armPlacements(side).some(has));
  if (arms.length === 0 && !hasLegs) return 'placements.needArm';
  for (const side of arms) {
    if (!has(`upper_arm_${side}`)) return 'placements.needUpperArm';
    if (has(`hand_${side}`) && !has(`forearm_${side}`)) return 'placements.needForearm';
  }
  return null;
}

/** Where the sensors of a live session are worn; only uploads hold single sensors that are worn nowhere. */
export function wornPlacements(session: Pick<SessionDetail, 'placements'>): Placement[] {
  return session.placements as Placement[];
}
