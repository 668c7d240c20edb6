import { Select, UnstyledButton } from '@mantine/core';
import { t } from '../../i18n';
import { signedColumn } from '../../lib/csv';
import './AxisColumn.css';

interface Props {
  axis: 'x' | 'y' | 'z';
  /** What it is a column of, for assistive technology. */
  name: string;
  columns: readonly string[];
  /** Of the mapping: a minus before it turns the axis. */
  value: string;
  onChange: (value: string) => void;
}

/** The column of one axis, and whether the axis points the other way. */
export function AxisColumn({ axis, name, columns, value, onChange }: Props) {
  const { column, isTurned } = signedColumn(value, columns);
  const label = `${name}: ${t('csv.axis', { axis })}`;
  return (
    <Select
      aria-label={label}
      leftSection={
        <UnstyledButton
          className="axis-sign"
          aria-pressed={isTurned}
          aria-label={`${label}, ${t('csv.turned')}`}
          title={t('csv.turned')}
          onClick={() => onChange(isTurned ? column : `-${column}`)}
        >
          {isTurned ? `−${axis}` : axis}
        </UnstyledButton>
      }
      leftSectionPointerEvents="auto"
      title={column || undefined}
      searchable
      data={columns.map((one) => ({ value: one, label: one }))}
      value={column || null}
      onChange={(chosen) => onChange(chosen && isTurned ? `-${chosen}` : (chosen ?? ''))}
    />
  );
}
