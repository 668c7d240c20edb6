// The template laid over the patient's running curves, in the patient's timing or at the therapist's own pace.
import type { ComparisonDetail, PhaseCurve } from '../../api/types';
import type { TemplateAt } from '../../charts/Traces';
import { displayUnit } from '../format';
import { bandEdges } from './comparison';
import { atPhase, repetitionAt, templateValueAt } from './warp';

export function templateOver(
  comparison: ComparisonDetail,
  templateDurationS: number | null,
  isWarped: boolean,
): TemplateAt {
  const curves = new Map(comparison.curves.map((curve) => [curve.channel, { ...curve, ...bandEdges(curve) }]));
  const repetitions = comparison.repetitions.map((one) => ({ ...one.repetition, warp: one.warp_template_phase }));
  return (channel, timeS) => {
    const curve = curves.get(channel);
    const repetition = curve && repetitionAt(repetitions, timeS);
    if (!curve || !repetition) return null;
    const durationS = templateDurationS ?? repetition.end_s - repetition.start_s;
    const { factor } = displayUnit(curve.unit);
    const at = (values: readonly (number | null)[]) =>
      factor * templateValueAt(values, repetition, repetition.warp, durationS, timeS, isWarped);
    return { mean: at(curve.mean), low: at(curve.low), high: at(curve.high) };
  };
}

/** The same over live curves: where the patient stands along the template is what guides her. */
export function templateLive(
  curves: readonly PhaseCurve[],
  /** The prescription's factor on the whole band. */
  scale: number,
  phaseAt: (timeS: number) => number | null,
): TemplateAt {
  const known = new Map(curves.map((curve) => [curve.channel, { ...curve, ...bandEdges(curve) }]));
  return (channel, timeS) => {
    const curve = known.get(channel);
    const phase = curve ? phaseAt(timeS) : null;
    if (!curve || phase === null) return null;
    const { factor } = displayUnit(curve.unit);
    const mean = factor * atPhase(curve.mean, phase);
    const edge = (values: readonly (number | null)[]) => mean + scale * (factor * atPhase(values, phase) - mean);
    return { mean, low: edge(curve.low), high: edge(curve.high) };
  };
}
