import { describe, expect, it } from 'vitest';
import {
  atPhase,
  patientPhase,
  phaseAt,
  templatePhaseAt,
  templateValueAt,
  timeAtTemplatePhase,
} from '../../../src/lib/assessment/warp';

const phases = Array.from({ length: 101 }, (_, phase) => phase);
/** A patient who is slow at first: template phase grows with the square of the patient's. */
const slowStart = phases.map((phase) => (phase / 100) ** 2 * 100);
/** A patient who stands still in the middle: the template waits at 40. */
const pause = phases.map((phase) => (phase < 40 ? phase : phase < 70 ? 40 : 40 + (phase - 70) * 2));
const repetition = { start_s: 10, end_s: 14 };

describe('warping between patient and template', () => {
  it('finds the patient phase whose template phase was asked for', () => {
    for (const wanted of [0, 1, 25, 50, 81, 99.5, 100]) {
      expect(atPhase(slowStart, patientPhase(slowStart, wanted))).toBeCloseTo(wanted, 6);
    }
  });

  it('takes the first moment of a pause', () => {
    expect(patientPhase(pause, 40)).toBeCloseTo(40);
    expect(patientPhase(pause, 41)).toBeGreaterThan(70);
  });

  it('is the identity for the same timing', () => {
    expect(timeAtTemplatePhase(repetition, phases, 50)).toBeCloseTo(12);
    expect(timeAtTemplatePhase(repetition, phases, 0)).toBe(10);
    expect(timeAtTemplatePhase(repetition, phases, 100)).toBe(14);
  });

  it('goes to the later moment of a patient who starts slowly', () => {
    expect(timeAtTemplatePhase(repetition, slowStart, 25)).toBeCloseTo(12);
  });

  it('puts the playhead where a click on the curve would go', () => {
    const repetitions = [
      { repetition, warp_template_phase: slowStart },
      { repetition: { start_s: 15, end_s: 17 }, warp_template_phase: phases },
    ];
    for (const phase of [1, 25, 50, 99]) {
      for (const one of repetitions)
        expect(
          templatePhaseAt(repetitions, timeAtTemplatePhase(one.repetition, one.warp_template_phase, phase)),
        ).toBeCloseTo(phase, 6);
    }
    expect(templatePhaseAt(repetitions, 14.5)).toBeNull();
  });

  it('has half-open repetitions', () => {
    expect(phaseAt(repetition, 10)).toBe(0);
    expect(phaseAt(repetition, 14)).toBeNull();
    expect(phaseAt(repetition, 9.99)).toBeNull();
  });

  it('follows the patient when warped, and the therapist’s own pace when not', () => {
    const mean = phases.map((phase) => phase * 2);
    expect(templateValueAt(mean, repetition, slowStart, 2, 12, true)).toBeCloseTo(50);
    expect(templateValueAt(mean, repetition, slowStart, 2, 11, false)).toBeCloseTo(100);
    expect(templateValueAt(mean, repetition, slowStart, 2, 13, false)).toBeNaN();
  });
});
