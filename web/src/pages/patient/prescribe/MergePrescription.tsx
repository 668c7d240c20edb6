// A prescription that somebody changed while this dialog was open: joined with it, field by field.
import { useMemo } from 'react';
import type { Prescription, Template } from '../../../api/types';
import { MergeCard, type MergeWords } from '../../../components/forms/MergeCard';
import { t } from '../../../i18n';
import { scheduleText } from '../../../lib/assessment/practice';
import { channelLabel } from '../../../lib/channels';
import { merge } from '../../../lib/editing/merge';
import { date, number, quantity } from '../../../lib/format';
import { unitOf } from '../../template/editor/words';
import { NO_TEMPLATE, valuesOf, type PrescribeValues } from './values';

const LABELS: Partial<Record<keyof PrescribeValues, () => string>> = {
  templateId: () => t('prescription.template'),
  repetitions: () => t('prescription.repetitionsLabel'),
  sets: () => t('prescription.setsLabel'),
  schedule: () => t('meanwhile.schedule'),
  percent: () => t('prescription.tolerance'),
  stops: () => t('prescription.stops'),
  question: () => t('prescription.question'),
  endsAt: () => t('prescription.until'),
};

function scheduled({ days, times, perWeek }: PrescribeValues['schedule']): string {
  return days.length ? scheduleText({ days: days.map(Number), times }) : t('meanwhile.perWeek', { count: perWeek });
}

function limited(stops: PrescribeValues['stops']): string {
  return stops
    .map((one) => {
      const curve = channelLabel(one.channel ?? '').text;
      const name = t(one.side === 'below' ? 'meanwhile.limitbelow' : 'meanwhile.limitabove', { curve });
      return `${name} ${quantity(one.limit ?? 0, unitOf(one.channel ?? ''))}`;
    })
    .join('; ');
}

function wordsOf(templates: readonly Template[]): MergeWords {
  return {
    label: (field) => LABELS[field as keyof PrescribeValues]?.() ?? field,
    value: (field, value) => {
      if (field === 'templateId')
        return value === NO_TEMPLATE
          ? t('prescription.without')
          : (templates.find((one) => one.id === value)?.name ?? t('prescription.otherTemplate'));
      if (field === 'schedule') return scheduled(value as PrescribeValues['schedule']);
      if (field === 'stops') return limited(value as PrescribeValues['stops']) || t('meanwhile.none');
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
  const joined = useMemo(
    () => merge({ ...valuesOf(base) }, { ...values }, { ...valuesOf(newest) }),
    [base, newest, values],
  );
  const change = newest.changes?.[0];
  const name = change?.changed_by ?? '';
  return (
    <MergeCard
      merge={joined}
      words={wordsOf(templates)}
      name={name}
      at={change?.changed_at ?? newest.starts_at}
      saved={(when) => t('meanwhile.changedIt', { name, when })}
      onTake={(merged) => onTake(merged as unknown as PrescribeValues)}
    />
  );
}
