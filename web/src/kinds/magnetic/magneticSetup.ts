// What a session with a magnetic source declares: where the source is worn, which sensors are around it, its coils.
import type { Placement, SessionIn, Side } from '../../api/types';

export const USES = ['back', 'arm', 'leg', 'feet', 'bench', 'other'] as const;
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
  lengthCm: number | null;
  depthCm: number | null;
}

export const USUAL: Coils = {
  radiusCm: null,
  turns: null,
  offsetCm: null,
  currentA: null,
  lengthCm: null,
  depthCm: null,
};
/** Coils around a shoe are wider than those on a belt. */
const SHOE = { coil_radius_m: 0.075, current_a: 1.36 };
const HIGHEST_A = 1.5;
/** Thin loops that stand for a winding, along and across. */
const LAYERS = [5, 3];
/** Every coil in turn, whatever the uncertainty; the sensor may lie on any side. */
const BENCH = { fixed_interval_s: 0.25, mounting_direction: [0, 0, 0] };

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

/** What is declared of the source; only what differs from its own defaults. */
export function sourceParameters(
  worn: Worn,
  coils: Coils,
  use: Use = 'other',
): NonNullable<SessionIn['orientation_parameters']> {
  const shoe = worn.source.startsWith('foot') ? SHOE : {};
  return {
    source: worn.source,
    ...shoe,
    ...(coils.radiusCm ? { coil_radius_m: coils.radiusCm / 100 } : {}),
    ...(coils.turns ? { coil_turns: coils.turns } : {}),
    ...(coils.offsetCm !== null ? { coil_offset_m: coils.offsetCm / 100 } : {}),
    ...(coils.lengthCm || coils.depthCm
      ? { coil_length_m: (coils.lengthCm ?? 0) / 100, coil_depth_m: (coils.depthCm ?? 0) / 100, coil_layers: LAYERS }
      : {}),
    ...(use === 'bench' ? BENCH : {}),
    ...(coils.currentA ? { current_a: coils.currentA, current_limit_a: Math.max(coils.currentA, HIGHEST_A) } : {}),
  };
}

/** Centimetres as they were typed; null where nothing was. */
export type Place = [number | null, number | null, number | null];

/** Metres, null for a stop that was left empty; null as a whole while a place is half typed or there are too few. */
export function placesOf(typed: readonly Place[]): ([number, number, number] | null)[] | null {
  const found: ([number, number, number] | null)[] = [];
  for (const [x, y, z] of typed) {
    if (x === null && y === null && z === null) found.push(null);
    else if (x === null || y === null || z === null) return null;
    else found.push([x / 100, y / 100, z / 100]);
  }
  return found.filter((one) => one !== null).length >= LEAST_PLACES ? found : null;
}
const LEAST_PLACES = 6;

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
