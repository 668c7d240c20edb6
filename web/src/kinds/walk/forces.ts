// What the live frames of two instrumented shoes say: loads, their state, balance and the foot angle.
import type { Player } from '../../player/types';

/** As `FORCE_STATES` of the service. */
export const FORCE_STATES = ['measured', 'not_tared', 'missing', 'implausible'] as const;
export type ForceState = (typeof FORCE_STATES)[number];
export const GRAVITY = 9.80665;

export interface FootReading {
  side: 'left' | 'right';
  state: ForceState | null;
  loadN: number;
  toeOutRad: number;
  strideM: number;
}

export interface WalkReading {
  timeS: number;
  feet: FootReading[];
  massKg: number;
  heightM: number;
  marginM: number;
  sigmaM: number;
}

const SIDES = ['left', 'right'] as const;

export const hasForces = (scalars: readonly string[]): boolean => scalars.includes('foot_left_force_state');
export const isUsable = (state: ForceState | null): boolean => state === 'measured' || state === 'not_tared';

/** The newest of everything; null before the first frame. */
export function readWalk(player: Player): WalkReading | null {
  const { timeS } = player.clock();
  const names = SIDES.flatMap((side) =>
    ['force_state', 'force_z_n', 'toe_out_rad', 'stride_length_m'].map((name) => `foot_${side}_${name}`),
  );
  const read = player.read(
    timeS - 0.5,
    timeS + 1e-6,
    [...names, 'body_mass_kg', 'centre_of_mass.z', 'margin_of_stability_m', 'centre_of_mass_sigma_m'],
    500,
  );
  const last = read.timeS.length - 1;
  if (last < 0) return null;
  const at = (column: number) => read.values[column]?.[last] ?? NaN;
  return {
    timeS,
    feet: SIDES.map((side, index) => ({
      side,
      state: FORCE_STATES[at(4 * index)] ?? null,
      loadN: at(4 * index + 1),
      toeOutRad: at(4 * index + 2),
      strideM: at(4 * index + 3),
    })),
    massKg: at(8),
    heightM: at(9),
    marginM: at(10),
    sigmaM: at(11),
  };
}
