// A new walk: whether the shoes measure forces, and how far apart the feet stand at the start.
import { NumberInput } from '@mantine/core';
import { useState } from 'react';
import type { Placement } from '../../api/types';
import { t } from '../../i18n';
import { FEET } from '../../lib/placements';
import { BeginForm, YesNo } from '../BeginForm';
import type { BeginProps } from '../kind';

const SHOES: Placement[] = ['heel_left', 'forefoot_left', 'heel_right', 'forefoot_right'];

export function BeginWalk(props: BeginProps) {
  const { exercise, purpose } = props;
  const [hasShoes, setShoes] = useState(false);
  const [apartCm, setApartCm] = useState<number | null>(null);
  return (
    <BeginForm
      {...props}
      declared={{
        ...exercise,
        purpose,
        placements: hasShoes ? SHOES : FEET,
        ...(apartCm !== null ? { feet_apart_m: apartCm / 100 } : {}),
      }}
    >
      <YesNo
        label={t('newSession.shoes')}
        description={t('newSession.shoesHelp')}
        value={hasShoes}
        onChange={setShoes}
      />
      <NumberInput
        label={t('newSession.apart')}
        description={t('newSession.apartHelp')}
        value={apartCm ?? ''}
        onChange={(value) => setApartCm(typeof value === 'number' ? value : null)}
        min={0}
        max={60}
        maw={480}
      />
    </BeginForm>
  );
}
