// What is measured with a magnetic source: a usual set, or source and sensors by hand; its coils where they differ.
import { Checkbox, NumberInput, Select } from '@mantine/core';
import type { MagneticSource, Placement, Side } from '../../api/types';
import { RadioCards } from '../../components/forms/Choice';
import { t } from '../../i18n';
import { placementLabel, placementList } from '../../lib/channels';
import { day, spreadAlone } from '../../lib/format';
import { USES, wornFor, type Coils, type Use, type Worn } from './magneticSetup';

const TRUNK: Placement[] = ['head', 'sternum', 'pelvis'];
const LIMBS = ['upper_arm', 'forearm', 'hand', 'thigh', 'shank', 'foot'] as const;
const GROUPS: {
  legend: 'placements.leftSide' | 'placements.rightSide' | 'placements.trunk';
  placements: Placement[];
}[] = [
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
  /** Measured sources of the clinic, and the one that is worn; null for one that was not measured. */
  sources: readonly MagneticSource[];
  sourceId: string | null;
  onSource: (id: string | null) => void;
  onUse: (use: Use, worn: Worn) => void;
  onCoils: (coils: Coils) => void;
}

export function SourceChoice({ use, worn, coils, side, sources, sourceId, onSource, onUse, onCoils }: Props) {
  const toggle = (placement: Placement) =>
    onUse(use, {
      ...worn,
      sensors: worn.sensors.includes(placement)
        ? worn.sensors.filter((one) => one !== placement)
        : [...worn.sensors, placement],
    });
  const places = (found: Worn) =>
    t('magnetic.useText', { source: placementList([found.source]), sensors: placementList(found.sensors) });
  const amount = (
    key: keyof Coils,
    label:
      | 'magnetic.radius'
      | 'magnetic.turns'
      | 'magnetic.offset'
      | 'magnetic.current'
      | 'sources.length'
      | 'sources.depth',
    usual: string,
    decimals: number,
  ) => (
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
        options={USES.map((one) => ({
          value: one,
          title: one === 'bench' ? t('sources.useBench') : t(`magnetic.use.${one}`),
          text:
            one === 'bench'
              ? t('sources.useBenchText')
              : one === 'other'
                ? t('magnetic.useOther')
                : places(wornFor(one, side)),
        }))}
      />
      {use === 'other' && (
        <>
          <Select
            label={t('magnetic.sourceAt')}
            data={ALL.map((one) => ({ value: one, label: placementLabel(one) }))}
            value={worn.source}
            onChange={(value) =>
              value && onUse(use, { source: value as Placement, sensors: worn.sensors.filter((one) => one !== value) })
            }
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
                      <Checkbox
                        key={placement}
                        label={placementLabel(placement)}
                        checked={worn.sensors.includes(placement)}
                        onChange={() => toggle(placement)}
                      />
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
      {sources.length > 0 && (
        <Select
          label={t('sources.which')}
          description={sourceId === null ? t('sources.describedHelp') : undefined}
          data={[
            ...sources.map((one) => ({
              value: one.id,
              label: `${one.name} – ${t('sources.line', { serial: one.serial, gain: spreadAlone(100 * one.gain_sigma, 1), method: t(`sources.method.${one.method}`), day: day(one.calibrated_at) })}`,
            })),
            { value: '', label: t('sources.described') },
          ]}
          value={sourceId ?? ''}
          onChange={(value) => onSource(value || null)}
          allowDeselect={false}
          maw={640}
        />
      )}
      {sourceId === null && (
        <details className="as-table">
          <summary>{t('magnetic.coils')}</summary>
          <p className="muted small">{t('magnetic.coilsText')}</p>
          <div className="parameter-grid">
            {amount('radiusCm', 'magnetic.radius', worn.source.startsWith('foot') ? '7.5' : '5.5', 2)}
            {amount('turns', 'magnetic.turns', '50', 0)}
            {amount('offsetCm', 'magnetic.offset', '6', 2)}
            {amount('currentA', 'magnetic.current', worn.source.startsWith('foot') ? '1.36' : '1.3', 2)}
            {amount('lengthCm', 'sources.length', '0', 2)}
            {amount('depthCm', 'sources.depth', '0', 2)}
          </div>
        </details>
      )}
    </>
  );
}
