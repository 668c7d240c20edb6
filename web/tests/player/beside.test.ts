import { expect, it, vi } from 'vitest';
import { withColumns } from '../../src/player/beside';
import type { Player } from '../../src/player/types';

const read = vi.fn(() => ({ timeS: Float64Array.of(9), values: [Float32Array.of(1)], isComplete: true }));
const seek = vi.fn();
const player = { read, seek, clock: () => ({ timeS: 1 }) } as unknown as Player;
const beside = withColumns(
  player,
  Float64Array.of(0, 0.1, 0.2, 0.3, 0.4),
  new Map([['foot_height_right_m', Float32Array.of(0, 1, 2, 3, 4)]]),
);

it('reads its own columns in the half-open interval, what else is asked with them comes empty', () => {
  const found = beside.read(0.1, 0.3, ['foot_height_right_m', 'foot_height_right_m.sigma']);
  expect([...found.timeS]).toEqual([0.1, 0.2]);
  expect(found.values.map((one) => [...one])).toEqual([[1, 2], []]);
  expect(beside.read(5, 6, ['foot_height_right_m']).timeS).toHaveLength(0);
  expect(read).not.toHaveBeenCalled();
});

it('leaves everything else to the player', () => {
  expect([...beside.read(0, 1, ['speed']).timeS]).toEqual([9]);
  expect(read).toHaveBeenCalledWith(0, 1, ['speed'], undefined);
  beside.seek(3);
  expect(seek).toHaveBeenCalledWith(3);
  expect(beside.clock().timeS).toBe(1);
});
