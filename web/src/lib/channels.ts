// Names of angles, scalars, points and placements in plain words, with the convention beside them.
import { t, tOr, withinSentence } from '../i18n';
import type { Placement } from '../api/types';
import { pairOf } from '../kinds/magnetic/magnetic';
import { LEG_JOINTS } from './placements';

/** A channel of the frames as people and experts read it. */
export interface ChannelLabel {
  /** Plain words, e.g. `Elbow flexion, right`. */
  text: string;
  /** Segments and rotation sequence, e.g. `humerus to forearm, Z-X-Y`; empty for scalars. */
  convention: string;
  unit: string;
  side: 'left' | 'right' | null;
  /** What clinicians call zero, in the unit of the frames: shown is the value less this. */
  zero: number;
}

/**
 * Where clinicians begin to count, where the ISB begins elsewhere: the forearm in neutral (the thumb up) is 90 degrees of
 * its pronation, and 0 of theirs, supination below.
 */
const ZERO: readonly (readonly [RegExp, number])[] = [[/^humerus_forearm_(left|right)_zxy_pronation$/, Math.PI / 2]];

/** What is taken off a channel before it is shown, in the unit of the frames; the only place that says so. */
export function zeroOf(name: string): number {
  return ZERO.find(([pattern]) => pattern.test(name))?.[1] ?? 0;
}

/** Of a leg in the ISB's sequence alone: in Z-Y-X it is a magnetic pair of sensors. */
const ANGLE = new RegExp(
  `^(thorax_humerus|humerus_forearm|forearm_hand|(?:${LEG_JOINTS.join('|')})(?=_[a-z]+_zxy))_(left|right)_([a-z]{3})_([a-z_]+)$`,
);
const RELATIVE = /^(.+)_zyx_(rotation|flexion|lateral)$/;
const DISTANCE = /^(.+)_distance(_sigma)?_m$/;
const SCALAR = /^(.*?)(?:_(left|right))?_(rad|m|mps|s|radps|n)$/;
const POINT = /^([a-z]+)(?:_(left|right))?\.([xyz])$/;
const SUFFIX_UNITS: Record<string, string> = { rad: 'rad', m: 'm', mps: 'm/s', s: 's', radps: 'rad/s', n: 'N' };

function sided(text: string, side: string | undefined): string {
  return side === 'left' || side === 'right' ? t('channel.sided', { name: text, side: t(`side.${side}`) }) : text;
}

function readable(name: string): string {
  const words = name.replaceAll('_', ' ');
  return words.charAt(0).toUpperCase() + words.slice(1);
}

/** Words for a channel; a name that is not known is shown readably, never hidden. */
export function channelLabel(name: string): ChannelLabel {
  return { ...named(name), zero: zeroOf(name) };
}

function named(name: string): Omit<ChannelLabel, 'zero'> {
  const angle = ANGLE.exec(name);
  if (angle) {
    const [, joint = '', side, sequence = '', movement = ''] = angle;
    return {
      text: sided(tOr(`angle.${joint}.${movement}`, readable(`${joint} ${movement}`)), side),
      convention: t('channel.convention', {
        joint: tOr(`joint.${joint}`, readable(joint)),
        sequence: sequence.toUpperCase().split('').join('\u2011'),
      }),
      unit: 'rad',
      side: side as 'left' | 'right',
    };
  }
  const relative = RELATIVE.exec(name);
  const pair = relative ? pairOf(relative[1] ?? '') : null;
  if (relative && pair) {
    return {
      text: t('magnetic.angleOf', {
        angle: t(`magnetic.angle.${relative[2] as 'rotation' | 'flexion' | 'lateral'}`),
        place: placementLabel(pair.sensor),
      }),
      convention: t('magnetic.against', { source: placementLabel(pair.source) }),
      unit: 'rad',
      side: null,
    };
  }
  const point = POINT.exec(name);
  if (point) {
    const [, place = '', side, axis = ''] = point;
    return {
      text: `${sided(tOr(`point.${place}`, readable(place)), side)}, ${tOr(`axis.${axis}`, axis)}`,
      convention: '',
      unit: 'm',
      side: (side as 'left' | 'right' | undefined) ?? null,
    };
  }
  const distance = DISTANCE.exec(name);
  if (distance) {
    const [, place = '', sigma] = distance;
    return {
      text: t(sigma ? 'magnetic.sigmaOf' : 'magnetic.distanceOf', { place: placementLabel(place) }),
      convention: '',
      unit: 'm',
      side: null,
    };
  }
  const scalar = SCALAR.exec(name);
  if (scalar) {
    const [, measure = '', side, suffix = ''] = scalar;
    // A direction is no side of the body.
    const direction = side ? tOr(`scalar.${measure}_${side}`, '') : '';
    if (direction) return { text: direction, convention: '', unit: SUFFIX_UNITS[suffix] ?? '', side: null };
    return {
      text: sided(tOr(`scalar.${measure}`, readable(measure)), side),
      convention: '',
      unit: SUFFIX_UNITS[suffix] ?? '',
      side: (side as 'left' | 'right' | undefined) ?? null,
    };
  }
  return { text: readable(name), convention: '', unit: '', side: null };
}

/** Words for a sensor placement. */
export function placementLabel(placement: Placement | string): string {
  return tOr(`placement.${placement}`, readable(placement));
}

/** Several places in a row, as they stand within a sentence: `left forearm, left hand`. */
export function placementList(placements: readonly string[]): string {
  return placements.map((one) => withinSentence(placementLabel(one))).join(', ');
}

/** The angles worth showing first: the exercise's own, then what a therapist looks at next. */
export function preferredAngles(
  angles: readonly string[],
  primary: string | null | undefined,
  side: string | null,
  count = 4,
): string[] {
  const order = [
    'humerus_forearm_{side}_zxy_flexion',
    'thorax_humerus_{side}_yxy_elevation',
    'thorax_humerus_{side}_yxy_plane_of_elevation',
    'humerus_forearm_{side}_zxy_pronation',
    'forearm_hand_{side}_zxy_flexion',
    'thorax_humerus_{side}_yxy_axial_rotation',
    'thigh_shank_{side}_zxy_flexion',
    'pelvis_thigh_{side}_zxy_flexion',
    'shank_foot_{side}_zxy_flexion',
  ];
  const sides = side === 'left' ? ['left', 'right'] : ['right', 'left'];
  const wanted = [
    ...(primary ? [primary] : []),
    ...sides.flatMap((one) => order.map((name) => name.replace('{side}', one))),
    ...angles,
  ];
  return [...new Set(wanted)].filter((name) => angles.includes(name)).slice(0, count);
}
