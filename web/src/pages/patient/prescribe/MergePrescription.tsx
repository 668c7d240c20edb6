// A prescription that somebody changed while this dialog was open: joined with it, field by field.
import { useMemo } from 'react';
import type { Prescription, StopDesign, Template } from '../../../api/types';
import { MergeCard, type MergeWords } from '../../../components/forms/MergeCard';
import { t } from '../../../i18n';
import { scheduleText } from '../../../lib/assessment/practice';
import { stopFields, stopsOfFields } from '../../../lib/editing/designFields';
import { merge, type Fields } from '../../../lib/editing/merge';
import { date, number } from '../../../lib/format';
import { namesOf, removedStops, stopName, stopText } from '../../template/editor/words';
import { NO_TEMPLATE, valuesOf, type PrescribeValues } from './values';

const LABELS: Partial<Record<keyof PrescribeValues, () => string>> = {
  templateId: () => t('prescription.template'),
  repetitions: () => t('prescription.repetitionsLabel'),
  sets: () => t('prescription.setsLabel'),
  schedule: () => t('meanwhile.schedule'),
  percent: () => t('prescription.tolerance'),
  question: () => t('prescription.question'),
  endsAt: () => t('prescription.until'),
};

function scheduled({ days, times, perWeek }: PrescribeValues['schedule']): string {
  return days.length ? scheduleText({ days: days.map(Number), times }) : t('meanwhile.perWeek', { count: perWeek });
}

/** The limits are a field each: two people may each add one. */
function fieldsOf({ stops, ...values }: PrescribeValues, opened: PrescribeValues['stops']): Fields {
  return { ...values, ...stopFields(stops, opened) };
}

function valuesOfFields(fields: Fields): PrescribeValues {
  const others = Object.entries(fields).filter(([name]) => !name.startsWith('stop:'));
  return { ...(Object.fromEntries(others) as unknown as Omit<PrescribeValues, 'stops'>), stops: stopsOfFields(fields) };
}

function wordsOf(templates: readonly Template[]): MergeWords {
  return {
    label: (field) =>
      field.startsWith('stop:') ? stopName(field) : (LABELS[field as keyof PrescribeValues]?.() ?? field),
    value: (field, value) => {
      if (field === 'templateId')
        return value === NO_TEMPLATE
          ? t('prescription.without')
          : (templates.find((one) => one.id === value)?.name ?? t('prescription.otherTemplate'));
      if (field === 'schedule') return scheduled(value as PrescribeValues['schedule']);
      if (field.startsWith('stop:')) return value ? stopText(value as StopDesign) : t('meanwhile.none');
      if (field === 'percent') return `${number(Number(value))} %`;
      if (field === 'endsAt') return value ? date(String(value)) : t('meanwhile.none');
      return String(value) || t('meanwhile.none');
    },
  };
}

export function MergePrescription({
  base,
  newest,
  values,
  templates,
  onTake,
}: {
  /** As this dialog opened it. */
  base: Prescription;
  /** As it is stored now. */
  newest: Prescription;
  values: PrescribeValues;
  templates: readonly Template[];
  onTake: (merged: PrescribeValues) => void;
}) {
  const joined = useMemo(() => {
    const opened = valuesOf(base);
    const fields = (one: PrescribeValues) => fieldsOf(one, opened.stops);
    return merge(fields(opened), fields(values), fields(valuesOf(newest)));
  }, [base, newest, values]);
  // The newest first; each change is one number more.
  const changes = newest.changes?.slice(0, Math.max(1, (newest.number ?? 1) - (base.number ?? 1))) ?? [];
  const people = new Set(changes.map((one) => one.changed_by).reverse());
  const name = namesOf([...people]);
  return (
    <MergeCard
      merge={joined}
      words={wordsOf(templates)}
      name={name}
      at={changes[0]?.changed_at ?? newest.starts_at}
      saved={(when) => t(people.size > 1 ? 'meanwhile.severalChangedIt' : 'meanwhile.changedIt', { name, when })}
      notes={removedStops(joined)}
      onTake={(merged) => onTake(valuesOfFields(merged))}
    />
  );
}
