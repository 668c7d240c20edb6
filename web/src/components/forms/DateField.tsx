// A day, typed: the browser's own field shows month or day first as the machine likes, not as the clinic does.
import { TextInput } from '@mantine/core';
import { useState } from 'react';
import { t } from '../../i18n';
import { dayWords, readDay } from '../../lib/dates';

export interface DateFieldProps {
  label: string;
  description?: string;
  /** `2025-03-31`, empty for none; what cannot be read is passed on as it is, see `isDateOrEmpty`. */
  value: string;
  /** Why a day that can be read cannot be. */
  problem?: string | null;
  onChange: (value: string) => void;
}

/** Whether a field's value can be sent. */
export const isDateOrEmpty = (value: string) => readDay(value) !== null;

/** Says what it understood as soon as the field is left, in words nobody can mistake. */
export function DateField({ label, description, value, problem, onChange }: DateFieldProps) {
  const [typed, setTyped] = useState(() => (value && isDateOrEmpty(value) ? dayWords(value) : value));
  const [isLeft, setLeft] = useState(false);
  const found = readDay(typed);
  return (
    <TextInput
      label={label}
      description={description}
      placeholder={t('date.example')}
      autoComplete="off"
      maw={300}
      value={typed}
      error={isLeft && found === null ? t('date.unclear') : (problem ?? null)}
      onChange={(event) => {
        const text = event.currentTarget.value;
        setTyped(text);
        setLeft(false);
        onChange(readDay(text) ?? text);
      }}
      onBlur={() => {
        setLeft(true);
        if (found) setTyped(dayWords(found));
      }}
    />
  );
}
