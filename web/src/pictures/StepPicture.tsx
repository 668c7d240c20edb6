import type { CalibrationStep } from '../api/types';
import type { Limb } from '../lib/placements';
import { FrontFigure, SideFigure } from './Mannequin';
import { LaidSensor, RestingSensors, TumbledSensor } from './SensorPicture';

type Picture = CalibrationStep['picture'];

const HANGING = [5, 4] as const;
const BENT = [0, 92] as const;

/** The drawing of each step; the words beside it say the same. Only limbs that are worn are in colour. */
const DRAWN: Record<Picture, (worn?: readonly Limb[]) => React.ReactElement> = {
  lie_still: () => <RestingSensors />,
  face_x_up: () => <LaidSensor axis="x" />,
  face_x_down: () => <LaidSensor axis="x" isDown />,
  face_y_up: () => <LaidSensor axis="y" />,
  face_y_down: () => <LaidSensor axis="y" isDown />,
  face_z_up: () => <LaidSensor axis="z" />,
  face_z_down: () => <LaidSensor axis="z" isDown />,
  turn_x: () => <LaidSensor axis="x" isTurned />,
  turn_y: () => <LaidSensor axis="y" isTurned />,
  turn_z: () => <LaidSensor axis="z" isTurned />,
  turn_all_ways: () => <TumbledSensor />,
  n_pose: (stressed) => <FrontFigure stressed={stressed} arm={HANGING} />,
  arm_hanging: (stressed) => <FrontFigure stressed={stressed} arm={HANGING} />,
  t_pose: (stressed) => <FrontFigure stressed={stressed} arm={[90, 90]} />,
  elbow_flexion: () => <SideFigure arm={[0, 140]} before={[0, 8]} turns="elbow" />,
  pronation: () => <SideFigure arm={BENT} turns="palm" />,
  raise_forward: () => <SideFigure arm={[90, 90]} before={HANGING} turns="shoulder" />,
  raise_sideways: (stressed) => <FrontFigure stressed={stressed} arm={[88, 88]} before={HANGING} turns="shoulder" />,
  seated_rest: () => <SideFigure isSeated arm={BENT} />,
  seated_elbow_flexion: () => <SideFigure isSeated isHelped arm={[0, 130]} before={[0, 70]} turns="elbow" />,
  seated_pronation: () => <SideFigure isSeated isHelped arm={BENT} turns="palm" />,
  seated_raise_forward: () => <SideFigure isSeated isHelped arm={[80, 80]} before={[0, 60]} turns="shoulder" />,
  seated_raise_sideways: (stressed) => (
    <FrontFigure stressed={stressed} isSeated arm={[70, 70]} before={HANGING} turns="shoulder" />
  ),
};

/** `worn`: the limbs that carry sensors; both arms where that is not known. */
export function StepPicture({ picture, worn }: { picture: Picture; worn?: readonly Limb[] }) {
  return DRAWN[picture](worn);
}
