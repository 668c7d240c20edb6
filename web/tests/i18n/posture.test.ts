// No sentence of the patient's pages contradicts how the exercise is done: sitting where she stands, standing where she sits.
import { describe, expect, it } from 'vitest';
import { speakWith, type Catalogue } from '../../src/i18n';
import { words as german } from '../../src/i18n/de';
import { doing as germanDoing } from '../../src/i18n/de/own/doing';
import { home as germanHome } from '../../src/i18n/de/own/home';
import { sensors as germanSensors } from '../../src/i18n/de/own/sensors';
import { words as english } from '../../src/i18n/en';
import { doing } from '../../src/i18n/en/own/doing';
import { home } from '../../src/i18n/en/own/home';
import { sensors } from '../../src/i18n/en/own/sensors';
import { wornLimbs } from '../../src/lib/placements';
import { forPosture } from '../../src/lib/posture';

const SITTING =
  /\b(?:sit|sits|sitting|seated?|chair|stool|lap)\b|\b(?:sitzen|sitzt|hinsetzen|setzen sie sich)\b|stuhl|lehne\b|\bhocker/i;
const STANDING = /\b(?:stand|stands|standing)\b|\b(?:steh|aufsteh|stellen sie sich)/i;
/** The calibration is done standing, before the exercise begins, and speaks of the pose it asks for. */
const OF_THE_CALIBRATION =
  /^home\.(?:moment\.(?:still|again)(?:\.text)?|standing|cannotStand)$|^consent|^caseload|^unit|^mine/;

type Words = Record<string, string | { one: string; other: string }>;
const textOf = (entry: string | { one: string; other: string }) =>
  typeof entry === 'string' ? entry : `${entry.one} ${entry.other}`;

describe.each([
  ['en', english, { ...doing, ...home, ...sensors }],
  ['de', german, { ...germanDoing, ...germanHome, ...germanSensors }],
] as [string, Catalogue, Words][])('%s', (language, words, own) => {
  it.each(['waiting', 'ready', 'upright'] as const)('fits the posture: %s', (what) => {
    speakWith(language, words);
    expect(forPosture(what, 'standing')).not.toMatch(SITTING);
    expect(forPosture(what, 'standing')).toMatch(STANDING);
    expect(forPosture(what, 'seated')).not.toMatch(STANDING);
    expect(forPosture(what, 'seated')).toMatch(SITTING);
    expect(forPosture(what, undefined)).not.toMatch(SITTING);
    expect(forPosture(what, undefined)).not.toMatch(STANDING);
    speakWith('en', english);
  });

  it('says nothing of a posture in any other word of an exercise', () => {
    const of = Object.entries(own).filter(([key]) => !OF_THE_CALIBRATION.test(key));
    expect(of.length).toBeGreaterThan(100);
    expect(of.filter(([, entry]) => SITTING.test(textOf(entry)) || STANDING.test(textOf(entry)))).toEqual([]);
  });
});

it('colours only the limbs that are worn', () => {
  expect(wornLimbs(['sternum', 'upper_arm_left', 'forearm_left'])).toEqual(['left_arm']);
  expect(wornLimbs(['pelvis', 'thigh_right', 'shank_right'])).toEqual(['right_leg']);
  expect(wornLimbs(['upper_arm_left', 'upper_arm_right'])).toEqual(['right_arm', 'left_arm']);
});
