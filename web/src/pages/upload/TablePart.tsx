// The part of the upload page that a table has: what it is taken for, and where all of that is changed.
import { Select } from '@mantine/core';
import { useEffect, useState } from 'react';
import type { GuessedMapping, Placement, TablePreview, UploadIn } from '../../api/types';
import { CsvMappingForm } from '../../components/forms/CsvMappingForm';
import { t } from '../../i18n';
import { complete } from '../../lib/csv';
import { LEG_PLACEMENTS } from '../../lib/placements';
import { FirstLook } from './FirstLook';

const PLACEMENTS: Placement[] = [
  'sternum',
  'upper_arm_right',
  'forearm_right',
  'hand_right',
  'upper_arm_left',
  'forearm_left',
  'hand_left',
  'pelvis',
  'head',
  'shoulder_left',
  'shoulder_right',
  ...LEG_PLACEMENTS,
];
/** `place`: where the service is. */
export type Hemisphere = NonNullable<UploadIn['hemisphere']> | 'place';
const HEMISPHERES: Hemisphere[] = ['place', 'north', 'south', 'unknown'];

export function HemisphereChoice({ value, onChange }: { value: Hemisphere; onChange: (value: Hemisphere) => void }) {
  return (
    <Select
      label={t('upload.hemisphere')}
      description={t('upload.hemisphereHelp')}
      maw={480}
      allowDeselect={false}
      data={HEMISPHERES.map((one) => ({ value: one, label: t(`upload.hemisphere.${one}`) }))}
      value={value}
      onChange={(chosen) => onChange(chosen ?? 'place')}
    />
  );
}

interface Props {
  seen: TablePreview;
  mapping: GuessedMapping;
  isChanging: boolean;
  /** Its sensors are on segments of a body. */
  hasPlaces: boolean;
  hemisphere: Hemisphere;
  onMapping: (mapping: GuessedMapping) => void;
  onHemisphere: (hemisphere: Hemisphere) => void;
}

export function TablePart({ seen, mapping, isChanging, hasPlaces, hemisphere, onMapping, onHemisphere }: Props) {
  const isComplete = complete(mapping, hasPlaces) !== null;
  const [isOpen, setOpen] = useState(!isComplete);
  // What is lacking is shown where it is said; nobody's open form is closed.
  useEffect(() => {
    if (!isComplete) setOpen(true);
  }, [isComplete]);
  return (
    <>
      <FirstLook seen={seen} isChanging={isChanging} />
      <details className="as-table" open={isOpen} onToggle={(event) => setOpen(event.currentTarget.open)}>
        <summary>{t('look.change')}</summary>
        {/* Hundreds of fields with many sensors: made for whoever opens them. */}
        {isOpen && (
          <div className="stack advanced">
            <CsvMappingForm
              head={seen}
              hasPlaces={hasPlaces}
              placements={PLACEMENTS}
              value={mapping}
              onChange={onMapping}
            />
            {hasField(mapping) && <HemisphereChoice value={hemisphere} onChange={onHemisphere} />}
          </div>
        )}
      </details>
    </>
  );
}

/** Only a magnetic field says whether north or south of the equator matters. */
export function hasField(mapping: GuessedMapping | null): boolean {
  return mapping?.signals.some((one) => one.quantity === 'magnetometer') ?? false;
}
