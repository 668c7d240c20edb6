import { ActionIcon, Button, NumberInput, Select } from '@mantine/core';
import { IconPlus, IconTrash } from '@tabler/icons-react';
import type { GuessedColumn, GuessedMapping, Placement, TablePreview } from '../../api/types';
import { t } from '../../i18n';
import { placementLabel } from '../../lib/channels';
import { mappingProblems, placed, type Quantity, type Unit } from '../../lib/csv';
import { AxisColumn } from './AxisColumn';
import './CsvMappingForm.css';

const UNITS: Record<Quantity, Unit[]> = {
  gyroscope: ['rad/s', 'deg/s', 'mdps'],
  accelerometer: ['m/s^2', 'g', 'mg'],
  magnetometer: ['uT', 'T', 'mT', 'G', 'mG', 'local'],
};
const UNIT_TEXT: Record<string, string> = { 'm/s^2': 'm/s²', uT: 'µT', local: '× 45 µT', 'deg/s': '°/s' };
const AXES = ['x', 'y', 'z'] as const;
const FIXED = '';

interface Props {
  head: Pick<TablePreview, 'columns' | 'rows' | 'skipped_lines'>;
  /** Its sensors are on segments of a body. */
  hasPlaces: boolean;
  placements: readonly Placement[];
  value: GuessedMapping;
  onChange: (mapping: GuessedMapping) => void;
}

/** Which column is what: a line a sensor and quantity, guessed by the service, corrected by hand. */
export function CsvMappingForm({ head, hasPlaces, placements, value, onChange }: Props) {
  const set = (index: number, change: Partial<GuessedColumn>) =>
    onChange({
      ...value,
      signals: value.signals.map((one, position) => (position === index ? { ...one, ...change } : one)),
    });
  const columns = head.columns.map((column) => ({ value: column, label: column }));
  const problems = mappingProblems(value, hasPlaces);
  return (
    <fieldset className="fieldset stack">
      <legend>{t('csv.title')}</legend>
      <p className="muted small">
        {t('csv.help', { count: head.columns.length })}{' '}
        {head.skipped_lines > 1 && t('csv.skipped', { count: head.skipped_lines + 1 })}
      </p>
      <details className="as-table">
        <summary>{t('csv.preview')}</summary>
        {/* eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex -- a scrolling region must be reachable by keyboard */}
        <div className="table-scroll" role="region" aria-label={t('csv.preview')} tabIndex={0}>
          <table className="plain-table">
            <thead>
              <tr>
                {head.columns.map((column) => (
                  <th scope="col" key={column}>
                    {column}
                  </th>
                ))}
              </tr>
            </thead>
            <tbody>
              {head.rows.map((row, index) => (
                <tr key={index}>
                  {row.map((field, column) => (
                    <td key={column} className="number">
                      {field}
                    </td>
                  ))}
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      </details>
      <div className="csv-time">
        <Select
          label={t('csv.time')}
          data={[{ value: FIXED, label: t('csv.fixedRate') }, ...columns]}
          value={value.time_column ?? FIXED}
          onChange={(column) =>
            onChange({
              ...value,
              time_column: column || null,
              // Clocks of their own would hold against what is chosen here.
              signals: value.signals.map((one) => ({ ...one, time_column: null })),
              rate_hz: column && value.time_unit !== 'count' ? null : (value.rate_hz ?? 100),
            })
          }
        />
        {value.time_column && (
          <Select
            label={t('csv.timeUnit')}
            data={(['s', 'ms', 'us', 'ns', 'clock', 'count'] as const).map((unit) => ({
              value: unit,
              label: t(`csv.unit.${unit}`),
            }))}
            value={value.time_unit ?? 's'}
            onChange={(unit) =>
              onChange({
                ...value,
                time_unit: unit as GuessedMapping['time_unit'],
                // The rate of a counter; stamps say their own.
                ...(value.time_unit === 'count' && { rate_hz: null }),
              })
            }
          />
        )}
        {(!value.time_column || value.time_unit === 'count') && (
          <NumberInput
            label={t('csv.rate')}
            suffix=" Hz"
            min={1}
            value={value.rate_hz ?? ''}
            onChange={(rate) => onChange({ ...value, rate_hz: Number(rate) || null })}
          />
        )}
      </div>
      <ul className="plain-list csv-signals">
        {value.signals.map((signal, index) => {
          const name = t('csv.signalName', { number: index + 1 });
          return (
            <li key={index} className="csv-signal">
              <Select
                aria-label={`${name}: ${t('csv.placement')}`}
                searchable
                data={placements.map((one) => ({ value: one, label: placementLabel(one) }))}
                clearable={!hasPlaces}
                value={signal.placement ?? null}
                onChange={(placement) => onChange(placed(value, signal, placement as Placement | null))}
                placeholder={!hasPlaces ? t('csv.single', { sensor: signal.sensor ?? '' }) : t('csv.choosePlacement')}
              />
              <Select
                aria-label={`${name}: ${t('csv.quantity')}`}
                data={(['gyroscope', 'accelerometer', 'magnetometer'] as const).map((one) => ({
                  value: one,
                  label: t(`csv.${one}`),
                }))}
                value={signal.quantity}
                onChange={(quantity) =>
                  set(index, {
                    quantity: quantity as Quantity,
                    unit: UNITS[quantity as Quantity][0] ?? 'rad/s',
                  })
                }
              />
              <Select
                aria-label={`${name}: ${t('csv.unitLabel')}`}
                data={UNITS[signal.quantity].map((unit) => ({ value: unit, label: UNIT_TEXT[unit] ?? unit }))}
                value={signal.unit}
                placeholder={t('csv.unitLabel')}
                error={!signal.unit}
                onChange={(unit) => set(index, { unit: unit as Unit })}
              />
              <ActionIcon
                size={42}
                color="gray"
                aria-label={t('csv.remove', { number: index + 1 })}
                onClick={() => onChange({ ...value, signals: value.signals.filter((_, other) => other !== index) })}
              >
                <IconTrash size={19} aria-hidden />
              </ActionIcon>
              {AXES.map((axis, position) => (
                <AxisColumn
                  key={axis}
                  axis={axis}
                  name={name}
                  columns={head.columns}
                  value={signal.columns[position] ?? ''}
                  onChange={(column) =>
                    set(index, {
                      columns: signal.columns.map((one, other) =>
                        other === position ? column : one,
                      ) as GuessedColumn['columns'],
                    })
                  }
                />
              ))}
            </li>
          );
        })}
      </ul>
      <div>
        <Button
          variant="default"
          size="sm"
          leftSection={<IconPlus size={17} aria-hidden />}
          onClick={() =>
            onChange({
              ...value,
              signals: [
                ...value.signals,
                { placement: placements[0] ?? 'sternum', quantity: 'gyroscope', columns: ['', '', ''], unit: 'rad/s' },
              ],
            })
          }
        >
          {t('csv.add')}
        </Button>
      </div>
      {problems.map((problem) => (
        <p key={problem} className="alert-text">
          {t(problem)}
        </p>
      ))}
    </fieldset>
  );
}
