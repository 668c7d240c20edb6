import type { Exercise, ExerciseIn, Posture } from '../api/types';

/** The joint angles whose range can be the main measure of an exercise. */
export function primaryAngles(side: 'left' | 'right'): string[] {
  return [
    `humerus_forearm_${side}_zxy_flexion`,
    `humerus_forearm_${side}_zxy_pronation`,
    `thorax_humerus_${side}_yxy_elevation`,
    `thorax_humerus_${side}_yxy_plane_of_elevation`,
    `thorax_humerus_${side}_yxy_axial_rotation`,
    `forearm_hand_${side}_zxy_flexion`,
    `forearm_hand_${side}_zxy_deviation`,
    `thigh_shank_${side}_zxy_flexion`,
    `pelvis_thigh_${side}_zxy_flexion`,
    `pelvis_thigh_${side}_zxy_abduction`,
    `pelvis_thigh_${side}_zxy_internal_rotation`,
    `shank_foot_${side}_zxy_flexion`,
    `shank_foot_${side}_zxy_inversion`,
  ];
}

/** The angle that usually tells most about a movement. */
export function usualAngle(movement: ExerciseIn['movement'], side: 'left' | 'right'): string {
  if (movement === 'abduction' || movement === 'flexion') return `thorax_humerus_${side}_yxy_elevation`;
  if (movement === 'pronation') return `humerus_forearm_${side}_zxy_pronation`;
  return `humerus_forearm_${side}_zxy_flexion`;
}

const WALKS: readonly string[] = ['walk', 'timed_up_and_go', 'six_minute_walk'];

/** Whether an exercise is a walking test: judged by time and distance, recorded with sensors on the feet. */
export function isWalk(movement: string | undefined): boolean {
  return movement !== undefined && WALKS.includes(movement);
}

export const POSTURES: readonly Posture[] = ['standing', 'seated'];

/** How a movement is usually done: at a table, or standing. */
export function usualPosture(movement: ExerciseIn['movement']): Posture {
  return ['reaching', 'drinking', 'pronation'].includes(movement) ? 'seated' : 'standing';
}

/** An exercise in the list of them all, once that is known. */
export function exerciseOf(exercises: readonly Exercise[] | undefined, id: string | null): Exercise | undefined {
  return exercises?.find((one) => one.id === id);
}
