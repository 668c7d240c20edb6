import type { Placement, Side, SessionDetail } from '../api/types';

/** What to wear for a walk. */
export const FEET: Placement[] = ['foot_left', 'foot_right'];

/** Sensors of one arm, from the shoulder outwards. */
export function armPlacements(side: 'left' | 'right'): Placement[] {
  return [`upper_arm_${side}`, `forearm_${side}`, `hand_${side}`];
}

/** What to wear for a side: the chest for the trunk, then the arm or both arms. */
export function suggestedPlacements(side: Side | null | undefined): Placement[] {
  if (side === 'both') return ['sternum', ...armPlacements('left'), ...armPlacements('right')];
  return ['sternum', ...armPlacements(side === 'left' ? 'left' : 'right')];
}

/** Sensors on the legs, thighs first: with the trunk they tell the centre of mass. */
export const LEG_PLACEMENTS: Placement[] = ['thigh_left', 'shank_left', 'thigh_right', 'shank_right'];

/** Whether the sensors tell the centre of mass of the body: one on the trunk and both thighs. */
export function tellsMassCentre(placements: readonly Placement[]): boolean {
  const has = (placement: Placement) => placements.includes(placement);
  return has('thigh_left') && has('thigh_right') && (has('sternum') || has('pelvis'));
}

/** What is missing, as a key of the catalogue; null when the choice makes sense. */
export function placementProblem(
  placements: readonly Placement[],
): 'placements.needUpperArm' | 'placements.needForearm' | 'placements.needArm' | 'placements.needThighs' | null {
  const has = (placement: Placement) => placements.includes(placement);
  if (LEG_PLACEMENTS.some(has) && !tellsMassCentre(placements)) return 'placements.needThighs';
  const arms = (['left', 'right'] as const).filter((side) => armPlacements(side).some(has));
  if (arms.length === 0 && !tellsMassCentre(placements)) return 'placements.needArm';
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
