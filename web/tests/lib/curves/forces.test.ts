import { describe, expect, it } from 'vitest';
import { FORCE_STATES, hasForces, isUsable, readWalk } from '../../../src/kinds/walk/forces';
import type { Player } from '../../../src/player/types';

const player = (values: Record<string, number>, timeS: number[] = [4.98, 4.99]): Player =>
  ({
    clock: () => ({ timeS: 5, startS: 0, endS: 5, isPlaying: true, speed: 1 }),
    read: (_from: number, _to: number, columns: readonly string[]) => ({
      timeS: new Float64Array(timeS),
      values: columns.map((name) => new Float32Array(timeS.map(() => values[name] ?? NaN))),
      isComplete: true,
    }),
  }) as unknown as Player;

describe('what the newest frame says of a walk', () => {
  it('reads both feet and the balance', () => {
    const found = readWalk(
      player({
        foot_left_force_state: 0,
        foot_left_force_z_n: 420,
        foot_left_toe_out_rad: 0.2,
        foot_right_force_state: 2,
        body_mass_kg: 80,
        'centre_of_mass.z': 0.95,
      }),
    );
    expect(found?.feet[0]).toMatchObject({ side: 'left', state: 'measured', loadN: 420 });
    expect(found?.feet[0]?.toeOutRad).toBeCloseTo(0.2);
    expect(found?.feet[1]?.state).toBe('missing');
    expect(found?.feet[1]?.loadN).toBeNaN();
    expect(found?.massKg).toBe(80);
    expect(found?.heightM).toBeCloseTo(0.95);
    expect(found?.marginM).toBeNaN();
  });

  it('has no state without load cells, and nothing before the first frame', () => {
    expect(readWalk(player({ foot_left_stride_length_m: 1.2 }))?.feet[0]).toMatchObject({ state: null });
    expect(readWalk(player({}, []))).toBeNull();
    expect(hasForces(['foot_left_stance'])).toBe(false);
    expect(hasForces(['foot_left_force_state'])).toBe(true);
    expect(FORCE_STATES.filter(isUsable)).toEqual(['measured', 'not_tared']);
  });
});
