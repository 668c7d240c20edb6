// Sessions with a magnetic source: flags in words, pulses from columns, the account in numbers.
import { isKey, type Key } from '../../i18n';

const FLAGS: readonly (readonly [bit: number, key: Key])[] = [
  [64, 'magnetic.flag.fault'],
  [16, 'magnetic.flag.missing'],
  [32, 'magnetic.flag.saturated'],
  [8, 'magnetic.flag.disturbed'],
  [4, 'magnetic.flag.inertial'],
  [256, 'magnetic.flag.gap'],
  [128, 'magnetic.flag.uncertain'],
];
const INVALID = 1;
const CALIBRATING = 2;

/** What is to be said of a sensor: what needs a hand first. One sentence while it has not started. */
export function stateKeys(bits: number): Key[] {
  if ((bits & CALIBRATING) !== 0) return ['magnetic.flag.calibrating'];
  const found = FLAGS.filter(([bit]) => (bits & bit) !== 0).map(([, key]) => key);
  if ((bits & INVALID) !== 0) return ['magnetic.none', ...found.filter((key) => key !== 'magnetic.flag.inertial')];
  return found.length ? found : ['magnetic.sound'];
}

/** Whether the first position is still to come. */
export function isStarting(bits: number): boolean {
  return (bits & (CALIBRATING | INVALID)) !== 0;
}

/** Uncertainties are shown as this many standard deviations, as the bands of the curves are. */
export const SIGMAS = 2;

/** Charge as it is printed on batteries. */
export function milliampereHours(ampereSeconds: number): number {
  return ampereSeconds / 3.6;
}

/** Whether somebody should look now. */
export function needsHand(bits: number): boolean {
  return (bits & CALIBRATING) === 0 && (bits & (64 | 16 | 32 | 8)) !== 0;
}

export interface Pulse {
  coil: number;
  startS: number;
  endS: number;
  currentA: number;
}

/** The pulses in a stretch of the columns `source_coil` and `source_current_a`. */
export function pulsesIn(timeS: ArrayLike<number>, coil: ArrayLike<number>, currentA: ArrayLike<number>): Pulse[] {
  const found: Pulse[] = [];
  let open: Pulse | null = null;
  const stepS = timeS.length > 1 ? ((timeS[timeS.length - 1] ?? 0) - (timeS[0] ?? 0)) / (timeS.length - 1) : 0;
  for (let index = 0; index < timeS.length; index += 1) {
    const number = coil[index] ?? 0;
    const at = timeS[index] ?? 0;
    if (open && number !== open.coil) open = null;
    if (number > 0) {
      if (!open) {
        open = { coil: number, startS: at, endS: at, currentA: currentA[index] ?? 0 };
        found.push(open);
      }
      open.endS = at + stepS;
    }
  }
  return found;
}

/** The column with the standard deviation of a channel: distances have one of their own name, angles a part of theirs. */
export function sigmaOf(channel: string): string {
  return /_distance_m$|^centre_of_mass_/.test(channel) ? channel.replace(/_m$/, '_sigma_m') : `${channel}.sigma`;
}

/** Whether a channel comes with its uncertainty; speeds and forces do not. */
export function hasSigma(channel: string): boolean {
  return !/_(mps|n|radps)$/.test(channel);
}

/** Source and sensor of a name that puts both together, such as `pelvis_upper_arm_left`. */
export function pairOf(name: string): { source: string; sensor: string } | null {
  for (let at = name.indexOf('_'); at > 0; at = name.indexOf('_', at + 1)) {
    const source = name.slice(0, at);
    const sensor = name.slice(at + 1);
    if (isKey(`placement.${source}`) && isKey(`placement.${sensor}`)) return { source, sensor };
  }
  return null;
}
