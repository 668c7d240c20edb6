// What is measured with a magnetic source: a usual set, or source and sensors by hand; its coils where they differ.
import { Checkbox, NumberInput, Select } from '@mantine/core';
import type { Placement, Side } from '../../api/types';
import { RadioCards } from '../../components/Choice';
import { t } from '../../i18n';
import { placementLabel } from '../../lib/channels';
import { USES, wornFor, type Coils, type Use, type Worn } from '../../lib/magneticSetup';

const TRUNK: Placement[] = ['head', 'sternum', 'pelvis'];
const LIMBS = ['upper_arm', 'forearm', 'hand', 'thigh', 'shank', 'foot'] as const;
const GROUPS: { legend: 'placements.leftSide' | 'placements.rightSide' | 'placements.trunk'; placements: Placement[] }[] = [
  { legend: 'placements.leftSide', placements: LIMBS.map((limb): Placement => `${limb}_left`) },
  { legend: 'placements.rightSide', placements: LIMBS.map((limb): Placement => `${limb}_right`) },
  { legend: 'placements.trunk', placements: TRUNK },
];
const ALL = GROUPS.flatMap((group) => group.placements);

interface Props {
  use: Use;
  worn: Worn;
  coils: Coils;
  side: Side | null | undefined;
  onUse: (use: Use, worn: Worn) => void;
  onCoils: (coils: Coils) => void;
}

export function SourceChoice({ use, worn, coils, side, onUse, onCoils }: Props) {
  const toggle = (placement: Placement) =>
    onUse(use, { ...worn, sensors: worn.sensors.includes(placement) ? worn.sensors.filter((one) => one !== placement) : [...worn.sensors, placement] });
  const places = (found: Worn) => t('magnetic.useText', { source: placementLabel(found.source), sensors: found.sensors.map(placementLabel).join(', ') });
  const amount = (key: keyof Coils, label: 'magnetic.radius' | 'magnetic.turns' | 'magnetic.offset' | 'magnetic.current', usual: string, decimals: number) => (
    <NumberInput
      label={t(label)}
      placeholder={usual}
      value={coils[key] ?? ''}
      onChange={(value) => onCoils({ ...coils, [key]: typeof value === 'number' ? value : null })}
      min={0}
      decimalScale={decimals}
      hideControls
    />
  );
  return (
    <>
      <RadioCards<Use>
        legend={t('magnetic.use')}
        value={use}
        onChange={(next) => onUse(next, next === 'other' ? worn : wornFor(next, side))}
        options={USES.map((one) => ({ value: one, title: t(`magnetic.use.${one}`), text: one === 'other' ? t('magnetic.useOther') : places(wornFor(one, side)) }))}
      />
      {use === 'other' && (
        <>
          <Select
            label={t('magnetic.sourceAt')}
            data={ALL.map((one) => ({ value: one, label: placementLabel(one) }))}
            value={worn.source}
            onChange={(value) => value && onUse(use, { source: value as Placement, sensors: worn.sensors.filter((one) => one !== value) })}
            allowDeselect={false}
            maw={480}
          />
          <fieldset className="fieldset">
            <legend>{t('magnetic.sensorsAt')}</legend>
            <div className="placement-groups" style={{ marginTop: 8 }}>
              {GROUPS.map((group) => (
                <fieldset key={group.legend} className="fieldset placement-group">
                  <legend>{t(group.legend)}</legend>
                  {group.placements
                    .filter((placement) => placement !== worn.source)
                    .map((placement) => (
                      <Checkbox key={placement} label={placementLabel(placement)} checked={worn.sensors.includes(placement)} onChange={() => toggle(placement)} />
                    ))}
                </fieldset>
              ))}
            </div>
          </fieldset>
          {worn.sensors.length === 0 && (
            <p className="alert-text" role="alert">
              {t('magnetic.needSensor')}
            </p>
          )}
        </>
      )}
      <details className="as-table">
        <summary>{t('magnetic.coils')}</summary>
        <p className="muted small">{t('magnetic.coilsText')}</p>
        <div className="parameter-grid">
          {amount('radiusCm', 'magnetic.radius', worn.source.startsWith('foot') ? '7.5' : '5.5', 2)}
          {amount('turns', 'magnetic.turns', '50', 0)}
          {amount('offsetCm', 'magnetic.offset', '6', 2)}
          {amount('currentA', 'magnetic.current', worn.source.startsWith('foot') ? '1.36' : '1.3', 2)}
        </div>
      </details>
    </>
  );
}
