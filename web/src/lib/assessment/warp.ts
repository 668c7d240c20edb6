// Between the patient's timing and the template's: which moment of a repetition belongs to which phase.

/** Value of a curve over phases 0..100 at any phase, linear between its points. */
export function atPhase(curve: readonly (number | null)[], phase: number): number {
  const last = curve.length - 1;
  const place = (Math.min(100, Math.max(0, phase)) / 100) * last;
  const lower = Math.min(last, Math.floor(place));
  const upper = Math.min(last, lower + 1);
  const share = place - lower;
  return (curve[lower] ?? NaN) * (1 - share) + (curve[upper] ?? NaN) * share;
}

/** Patient phase at which the patient is at the given template phase: the inverse of a never decreasing warp. */
export function patientPhase(warpTemplatePhase: readonly number[], templatePhase: number): number {
  const last = warpTemplatePhase.length - 1;
  if (last < 1) return templatePhase;
  const scale = 100 / last;
  if (templatePhase <= (warpTemplatePhase[0] ?? 0)) return 0;
  for (let index = 1; index <= last; index += 1) {
    const before = warpTemplatePhase[index - 1] ?? 0;
    const after = warpTemplatePhase[index] ?? 0;
    if (after >= templatePhase) {
      const share = after > before ? (templatePhase - before) / (after - before) : 0;
      return (index - 1 + share) * scale;
    }
  }
  return 100;
}

/** Session time of a repetition at a phase of the template. */
export function timeAtTemplatePhase(
  repetition: { start_s: number; end_s: number },
  warpTemplatePhase: readonly number[],
  templatePhase: number,
): number {
  const phase = patientPhase(warpTemplatePhase, templatePhase);
  return repetition.start_s + (phase / 100) * (repetition.end_s - repetition.start_s);
}

/** Phase of a repetition at a session time, or null outside it; intervals are half-open. */
export function phaseAt(repetition: { start_s: number; end_s: number }, timeS: number): number | null {
  if (timeS < repetition.start_s || timeS >= repetition.end_s) return null;
  return ((timeS - repetition.start_s) / (repetition.end_s - repetition.start_s)) * 100;
}

/** The repetition at a session time, if any. */
export function repetitionAt<R extends { start_s: number; end_s: number }>(
  repetitions: readonly R[],
  timeS: number,
): R | null {
  return repetitions.find((one) => timeS >= one.start_s && timeS < one.end_s) ?? null;
}

/** Where a moment stands in curves over the template's phases: the inverse of `timeAtTemplatePhase`; null between repetitions. */
export function templatePhaseAt(
  repetitions: readonly { repetition: { start_s: number; end_s: number }; warp_template_phase: readonly number[] }[],
  timeS: number,
): number | null {
  for (const { repetition, warp_template_phase: warp } of repetitions) {
    const phase = phaseAt(repetition, timeS);
    if (phase !== null) return atPhase(warp, phase);
  }
  return null;
}

/** The template's value at the patient's moment: followed in the patient's timing, or at the therapist's own pace. */
export function templateValueAt(
  mean: readonly (number | null)[],
  repetition: { start_s: number; end_s: number },
  warpTemplatePhase: readonly number[],
  templateDurationS: number,
  timeS: number,
  warped: boolean,
): number {
  const phase = phaseAt(repetition, timeS);
  if (phase === null) return NaN;
  if (warped) return atPhase(mean, atPhase(warpTemplatePhase, phase));
  const own = ((timeS - repetition.start_s) / templateDurationS) * 100;
  return own > 100 ? NaN : atPhase(mean, own);
}
