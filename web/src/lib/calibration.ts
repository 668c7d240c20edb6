import type { CalibrationIn, CalibrationMessage, Placement, SessionEvent } from '../api/types';

/** Whether a guided calibration is under way. */
export function isRunning({ phase }: CalibrationMessage): boolean {
  return phase === 'collecting' || phase === 'evaluating';
}

const UNCHECKED = 'calibration.not_checked';

/** Whether the only word on a calibration is that no movement has checked it. */
export function isUnchecked({ kind, sentences }: Pick<SessionEvent, 'kind' | 'sentences'>): boolean {
  const said = sentences?.text;
  return kind === 'calibration' && !!said && !Array.isArray(said) && said.code === UNCHECKED;
}

/** The reasons of a calibration without that no movement has checked it, and whether that was among them. */
export function reasonsOf(of: Pick<CalibrationMessage, 'reasons' | 'sentences'>): {
  isUnchecked: boolean;
  reasons: string[];
} {
  const said = of.sentences?.reasons;
  const all = of.reasons ?? [];
  const codes = all.map((_, at) => {
    const one = Array.isArray(said) ? said[at] : undefined;
    return typeof one === 'object' ? one.code : '';
  });
  return { isUnchecked: codes.includes(UNCHECKED), reasons: all.filter((_, at) => codes[at] !== UNCHECKED) };
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
