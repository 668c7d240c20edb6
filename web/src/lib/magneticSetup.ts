// What a session with a magnetic source is told: where the source is worn, which sensors are around it, its coils.
import type { Placement, SessionIn, Side } from '../api/types';

export const USES = ['back', 'arm', 'leg', 'feet', 'other'] as const;
export type Use = (typeof USES)[number];

export interface Worn {
  source: Placement;
  sensors: Placement[];
}

/** As the maker of the source states them; null for the usual ones. */
export interface Coils {
  radiusCm: number | null;
  turns: number | null;
  offsetCm: number | null;
  currentA: number | null;
}

export const USUAL: Coils = { radiusCm: null, turns: null, offsetCm: null, currentA: null };
/** Coils around a shoe are wider than those on a belt. */
const SHOE = { coil_radius_m: 0.075, current_a: 1.36 };
const HIGHEST_A = 1.5;

/** What is worn for a use, on the side that is treated; `other` starts from the back and is then changed by hand. */
export function wornFor(use: Use, side: Side | null | undefined): Worn {
  const own = side === 'left' ? 'left' : 'right';
  switch (use) {
    case 'arm':
      return { source: 'pelvis', sensors: [`upper_arm_${own}`, `hand_${own}`] };
    case 'leg':
      return { source: 'pelvis', sensors: [`thigh_${own}`] };
    case 'feet':
      return { source: 'foot_left', sensors: ['foot_right'] };
    default:
      return { source: 'pelvis', sensors: ['sternum'] };
  }
}

/** What the service is told of the source; only what differs from its own defaults. */
export function sourceParameters(worn: Worn, coils: Coils): NonNullable<SessionIn['orientation_parameters']> {
  const shoe = worn.source.startsWith('foot') ? SHOE : {};
  return {
    source: worn.source,
    ...shoe,
    ...(coils.radiusCm ? { coil_radius_m: coils.radiusCm / 100 } : {}),
    ...(coils.turns ? { coil_turns: coils.turns } : {}),
    ...(coils.offsetCm !== null ? { coil_offset_m: coils.offsetCm / 100 } : {}),
    ...(coils.currentA ? { current_a: coils.currentA, current_limit_a: Math.max(coils.currentA, HIGHEST_A) } : {}),
  };
}

/** The movement of the simulated person that comes nearest to what is worn. */
export function simulatedMovement(placements: readonly Placement[]): 'flexion' | 'shoulder' | 'hip' | 'feet' {
  const has = (part: string) => placements.some((one) => one.startsWith(part));
  if (has('foot_left') && has('foot_right')) return 'feet';
  if (has('thigh')) return 'hip';
  return has('upper_arm') || has('hand') ? 'shoulder' : 'flexion';
}

/** Both questions about implants, as they were answered. */
export type Word = 'none' | 'some' | '';
export interface Implants {
  patient: Word;
  nearby: Word;
}
export const UNASKED: Implants = { patient: '', nearby: '' };
export const isSafe = (said: Implants) => said.patient === 'none' && said.nearby === 'none';
export const isForbidden = (said: Implants) => said.patient === 'some' || said.nearby === 'some';
