// Choices as cards: large targets, a radio or checkbox underneath, so keyboard and readers get the real thing.
import { useId, type CSSProperties, type ReactNode } from 'react';
import type { Side } from '../../api/types';
import { t } from '../../i18n';
import { SideMark } from '../Marks';
import './Choice.css';

export interface Option<V extends string> {
  value: V;
  title: ReactNode;
  text?: ReactNode;
}

/** One of several, each with its sentence. */
export function RadioCards<V extends string>({
  legend,
  help,
  options,
  value,
  onChange,
  columns = 1,
}: {
  legend: string;
  help?: string;
  options: readonly Option<V>[];
  value: V | '';
  onChange: (value: V) => void;
  columns?: number;
}) {
  const name = useId();
  return (
    <fieldset className="fieldset">
      <legend>{legend}</legend>
      {help && <p className="muted small">{help}</p>}
      <div className="radio-cards" style={{ '--columns': columns } as CSSProperties}>
        {options.map((option) => (
          <label key={option.value} className="radio-card">
            <input
              type="radio"
              name={name}
              value={option.value}
              checked={value === option.value}
              onChange={() => onChange(option.value)}
            />
            <span>
              <span className="strong">{option.title}</span>
              {option.text && <span className="muted small radio-card-text">{option.text}</span>}
            </span>
          </label>
        ))}
      </div>
    </fieldset>
  );
}

/** Left, right, both, or not stated. */
export function SideChoice({
  legend,
  value,
  onChange,
  allowNone,
}: {
  legend: string;
  value: Side | '';
  onChange: (side: Side | '') => void;
  allowNone?: boolean;
}) {
  const options: Option<Side | 'none'>[] = (['left', 'right', 'both'] as const).map((side) => ({
    value: side,
    title: <SideMark side={side} />,
  }));
  if (allowNone) options.push({ value: 'none', title: t('side.none') });
  return (
    <RadioCards
      legend={legend}
      options={options}
      value={value === '' ? 'none' : value}
      onChange={(chosen) => onChange(chosen === 'none' ? '' : chosen)}
      columns={2}
    />
  );
}
