// Where sensors are worn: a figure that can be read, and checkboxes that do the choosing.
import { Checkbox } from '@mantine/core';
import type { Placement } from '../../api/types';
import { t } from '../../i18n';
import { placementLabel } from '../../lib/channels';
import { armPlacements, LEG_PLACEMENTS } from '../../lib/placements';
import { WornFigure } from '../Figures';
import './PlacementChoice.css';

const GROUPS: {
  legend: 'placements.trunk' | 'placements.leftArm' | 'placements.rightArm' | 'placements.legs';
  placements: Placement[];
}[] = [
  { legend: 'placements.leftArm', placements: armPlacements('left') },
  { legend: 'placements.rightArm', placements: armPlacements('right') },
  { legend: 'placements.trunk', placements: ['sternum', 'pelvis', 'head'] },
  { legend: 'placements.legs', placements: LEG_PLACEMENTS },
];

export function PlacementChoice({
  value,
  onChange,
}: {
  value: readonly Placement[];
  onChange: (placements: Placement[]) => void;
}) {
  const toggle = (placement: Placement) =>
    onChange(value.includes(placement) ? value.filter((one) => one !== placement) : [...value, placement]);
  return (
    <fieldset className="fieldset">
      <legend>{t('placements.legend')}</legend>
      <p className="muted small">{t('placements.help')}</p>
      <div className="placement-choice">
        <WornFigure worn={value} />
        <div className="placement-groups">
          {GROUPS.map((group) => (
            <fieldset key={group.legend} className="fieldset placement-group">
              <legend>{t(group.legend)}</legend>
              {group.placements.map((placement) => (
                <Checkbox
                  key={placement}
                  label={placementLabel(placement)}
                  checked={value.includes(placement)}
                  onChange={() => toggle(placement)}
                />
              ))}
            </fieldset>
          ))}
        </div>
      </div>
    </fieldset>
  );
}
