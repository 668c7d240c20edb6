// What the form of a prescription holds, made of a prescription and back.
import type { Prescription, PrescriptionIn, StopDesign } from '../../../api/types';

export const NO_TEMPLATE = 'none';
/** Limits of the factor on the band, in percent. */
export const NARROWEST = 50;
export const WIDEST = 300;

export interface PrescribeValues {
  exerciseId: string | null;
  /** `NO_TEMPLATE`: without one; null: not chosen yet, the first that there is. */
  templateId: string | null;
  repetitions: number;
  sets: number;
  schedule: { days: string[]; times: string[]; perWeek: number };
  percent: number | string;
  stops: StopDesign[];
  question: string;
  /** A day by the clocks of this browser, or empty. */
  endsAt: string;
}

/** The day of a moment by the clocks of this browser, as a field of a form has it. */
function localDay(moment: string): string {
  const at = new Date(moment);
  const two = (value: number) => String(value).padStart(2, '0');
  return `${at.getFullYear()}-${two(at.getMonth() + 1)}-${two(at.getDate())}`;
}

/** A prescription as the form shows it; without one what a new form begins with. */
export function valuesOf(prescription: Prescription | undefined): PrescribeValues {
  return {
    exerciseId: prescription?.exercise_id ?? null,
    templateId: prescription ? (prescription.template_id ?? NO_TEMPLATE) : null,
    repetitions: prescription?.repetitions ?? 10,
    sets: prescription?.sets ?? 1,
    schedule: {
      days: prescription?.days.map(String) ?? [],
      times: prescription?.times ?? [],
      perWeek: prescription?.times_per_week ?? 5,
    },
    percent: Math.round(100 * (prescription?.tolerance_scale ?? 1)),
    stops: prescription?.stops ?? [],
    question: prescription?.question ?? '',
    endsAt: prescription?.ends_at ? localDay(prescription.ends_at) : '',
  };
}

/** What is sent; `templateId` is the chosen one, and a walk has no sets, repetitions or limits. */
export function wantedOf(
  values: PrescribeValues,
  templateId: string,
  isWalked: boolean,
  before: Prescription | undefined,
): Omit<PrescriptionIn, 'exercise_id'> {
  const hasTemplate = templateId !== NO_TEMPLATE;
  const { days, times, perWeek } = values.schedule;
  return {
    template_id: hasTemplate ? templateId : null,
    repetitions: isWalked ? 1 : values.repetitions,
    sets: isWalked ? 1 : values.sets,
    times_per_week: perWeek,
    days: days.map(Number),
    times: days.length ? times.filter(Boolean) : [],
    tolerance_scale: hasTemplate ? Math.min(WIDEST, Math.max(NARROWEST, Number(values.percent) || 100)) / 100 : 1,
    stops: hasTemplate && !isWalked ? values.stops : [],
    question: values.question,
    // An end that was not touched keeps its moment.
    ends_at: !values.endsAt
      ? null
      : before?.ends_at && values.endsAt === localDay(before.ends_at)
        ? before.ends_at
        : new Date(`${values.endsAt}T23:59:59`).toISOString(),
  };
}
