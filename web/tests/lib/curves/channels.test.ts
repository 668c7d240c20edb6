import { describe, expect, it } from 'vitest';
import { channelLabel, placementList, preferredAngles } from '../../../src/lib/channels';

it('names places within a sentence without capitals', () => {
  expect(placementList(['sternum', 'forearm_left'])).toBe('chest, left forearm');
});

describe('channelLabel', () => {
  it('names an angle in plain words with its sequence beside it', () => {
    expect(channelLabel('humerus_forearm_right_zxy_flexion')).toMatchObject({
      text: 'Elbow flexion, right',
      convention: 'forearm to upper arm, Z\u2011X\u2011Y',
      unit: 'rad',
      side: 'right',
    });
    expect(channelLabel('thorax_humerus_left_yxy_plane_of_elevation').text).toBe('Shoulder plane of elevation, left');
    expect(channelLabel('thigh_shank_left_zxy_flexion')).toMatchObject({ text: 'Knee flexion, left', side: 'left' });
    // The same two places as a magnetic pair.
    expect(channelLabel('pelvis_thigh_left_zyx_flexion').text).not.toContain('Hip');
  });
  it('names scalars and points with their unit', () => {
    expect(channelLabel('trunk_lean_forward_rad')).toMatchObject({ text: 'Trunk forward lean', unit: 'rad' });
    expect(channelLabel('hand_speed_right_mps')).toMatchObject({ text: 'Hand speed, right', unit: 'm/s' });
    expect(channelLabel('hand_right.z')).toMatchObject({ text: 'Hand, right, height', unit: 'm' });
  });
  it('shows a name it does not know instead of hiding it', () => {
    expect(channelLabel('some_new_thing').text).toBe('Some new thing');
  });
});

describe('preferredAngles', () => {
  const angles = [
    'thorax_humerus_left_yxy_elevation',
    'humerus_forearm_left_zxy_flexion',
    'humerus_forearm_left_zxy_pronation',
  ];
  it('begins with the exercise’s own angle and shows nothing that is not there', () => {
    expect(preferredAngles(angles, 'humerus_forearm_left_zxy_pronation', 'left', 2)).toEqual([
      'humerus_forearm_left_zxy_pronation',
      'humerus_forearm_left_zxy_flexion',
    ]);
    expect(preferredAngles([], 'humerus_forearm_left_zxy_pronation', 'left')).toEqual([]);
  });
});
