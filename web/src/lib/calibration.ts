import type { CalibrationIn, CalibrationMessage, Placement } from '../api/types';

/** Whether a guided calibration is under way. */
export function isRunning({ phase }: CalibrationMessage): boolean {
  return phase === 'collecting' || phase === 'evaluating';
}

export type Limb = NonNullable<CalibrationIn['limbs']>[number];

const LIMB_OF: readonly (readonly [string, Limb])[] = [
  ['_right', 'right_arm'],
  ['_left', 'left_arm'],
];
const TRUNK: readonly Placement[] = ['head', 'sternum', 'pelvis'];
const LEGS = /^(thigh|shank|foot)_/;

/** The limbs that carry sensors, in the order of the buttons. */
export function wornLimbs(placements: readonly Placement[]): Limb[] {
  const found = new Set<Limb>();
  for (const placement of placements) {
    if (LEGS.test(placement)) found.add('legs');
    else if (TRUNK.includes(placement)) found.add('trunk');
    else {
      const limb = LIMB_OF.find(([ending]) => placement.endsWith(ending));
      if (limb) found.add(limb[1]);
    }
  }
  return (['right_arm', 'left_arm', 'trunk', 'legs'] as const).filter((limb) => found.has(limb));
}
