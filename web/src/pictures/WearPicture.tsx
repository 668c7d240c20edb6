// A person from the front with a sensor on each place that this exercise needs.
import type { Placement } from '../api/types';
import { wornLimbs } from '../lib/placements';
import { FrontFigure } from './Mannequin';
import './WearPicture.css';

/** Places on the drawing, the person's own left on the right-hand side; where the box is, and how it is turned. */
const PLACES: Partial<Record<Placement, readonly [x: number, y: number]>> = {
  head: [120, 24],
  sternum: [120, 92],
  pelvis: [120, 158],
  shoulder_left: [139, 76],
  shoulder_right: [101, 76],
  upper_arm_left: [152, 112],
  upper_arm_right: [88, 112],
  forearm_left: [156, 164],
  forearm_right: [84, 164],
  hand_left: [160, 196],
  hand_right: [80, 196],
  thigh_left: [136, 202],
  thigh_right: [104, 202],
  shank_left: [137, 252],
  shank_right: [103, 252],
  foot_left: [139, 286],
  foot_right: [101, 286],
};

/** Below this nothing of the legs is needed. */
const HIPS = 210;

/** The numbers of the list beside it, drawn where each sensor sits; as large as they can be. */
export function WearPicture({ placements, label }: { placements: readonly Placement[]; label: string }) {
  const isWhole = placements.some((place) => (PLACES[place]?.[1] ?? 0) > HIPS - 10);
  const view = isWhole ? '60 0 120 306' : `60 6 120 ${HIPS}`;
  return (
    <div className="wear-picture" role="img" aria-label={label}>
      <FrontFigure arm={[5, 4]} view={view} stressed={wornLimbs(placements)} />
      <svg viewBox={view} aria-hidden>
        {placements.map((place, index) => {
          const at = PLACES[place];
          return at ? (
            <g key={place} className="wear-sensor">
              <circle cx={at[0]} cy={at[1]} r="11" />
              <text x={at[0]} y={at[1] + 5}>
                {index + 1}
              </text>
            </g>
          ) : null;
        })}
      </svg>
    </div>
  );
}
