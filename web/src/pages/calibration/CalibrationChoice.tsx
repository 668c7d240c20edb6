// Which calibration: the usual pose at once, other ways for other patients, and sensors in the hand.
import { Button, Group, Select } from '@mantine/core';
import { useState } from 'react';
import { useCalibrations } from '../../api/queries';
import type { CalibrationGuide, CalibrationIn, CalibrationKind, Placement } from '../../api/types';
import { RadioCards } from '../../components/forms/Choice';
import { QueryBoundary } from '../../components/Feedback';
import { t } from '../../i18n';
import { wornLimbs } from '../../lib/placements';
import { placementLabel } from '../../lib/channels';
import { StepPicture } from '../../pictures/StepPicture';
import './CalibrationChoice.css';
import './calibration.css';

const USUAL: CalibrationKind = 'n_pose';

interface ChoiceProps {
  placements: readonly Placement[];
  hint: string;
  mayAct: boolean;
  isBusy: boolean;
  isRemembered?: boolean;
  onStart: (wanted: CalibrationIn) => void;
  onClose?: () => void;
}

function Others({
  guides,
  isBusy,
  onStart,
}: {
  guides: CalibrationGuide[];
  isBusy: boolean;
  onStart: (kind: CalibrationKind) => void;
}) {
  const [kind, setKind] = useState<CalibrationKind>(guides[0]?.kind ?? USUAL);
  return (
    <div className="stack">
      <RadioCards
        legend={t('guide.others')}
        value={kind}
        onChange={setKind}
        options={guides.map((one) => ({ value: one.kind, title: one.title, text: one.summary }))}
      />
      <div>
        <Button loading={isBusy} onClick={() => onStart(kind)}>
          {t('guide.begin')}
        </Button>
      </div>
    </div>
  );
}

function InTheHand({
  guides,
  placements,
  isBusy,
  onStart,
}: {
  guides: CalibrationGuide[];
  placements: readonly Placement[];
  isBusy: boolean;
  onStart: (wanted: CalibrationIn) => void;
}) {
  const [kind, setKind] = useState<CalibrationKind>(guides[0]?.kind ?? 'static_bias');
  const [place, setPlace] = useState<Placement | null>(placements[0] ?? null);
  const isOne = guides.find((one) => one.kind === kind)?.one_sensor ?? false;
  return (
    <div className="stack">
      <RadioCards
        legend={t('guide.inHand')}
        help={t('guide.inHandHelp')}
        value={kind}
        onChange={setKind}
        options={guides.map((one) => ({ value: one.kind, title: one.title, text: one.summary }))}
      />
      {isOne && (
        <Select
          label={t('guide.whichSensor')}
          data={placements.map((one) => ({ value: one, label: placementLabel(one) }))}
          value={place}
          onChange={(value) => setPlace(value as Placement)}
          maw={320}
        />
      )}
      <div>
        <Button
          loading={isBusy}
          disabled={isOne && !place}
          onClick={() => onStart({ kind, placements: isOne && place ? [place] : [] })}
        >
          {t('guide.begin')}
        </Button>
      </div>
    </div>
  );
}

export function CalibrationChoice({
  placements,
  hint,
  mayAct,
  isBusy,
  isRemembered = false,
  onStart,
  onClose,
}: ChoiceProps) {
  const guides = useCalibrations();
  return (
    <QueryBoundary of={guides} lines={5}>
      {(list) => {
        const usual = list.find((one) => one.kind === USUAL);
        const step = usual?.steps[0];
        const worn = list.filter((one) => one.worn && one.kind !== USUAL && one.kind !== 'heading_reset');
        const inHand = list.filter((one) => !one.worn);
        return (
          <section className="card" aria-labelledby="calibration">
            <div className="guide">
              <div className="guide-picture">
                {step && <StepPicture picture={step.picture} worn={wornLimbs(placements)} />}
              </div>
              <div className="guide-words">
                <h2 id="calibration">{t(isRemembered ? 'calibration.rememberedTitle' : 'calibration.title')}</h2>
                {isRemembered && <p>{t('calibration.rememberedText')}</p>}
                <ol className="calibration-steps">
                  <li>{t('calibration.stand')}</li>
                  <li>{t('calibration.arms')}</li>
                  <li>{t('calibration.still')}</li>
                </ol>
                {hint && (
                  <p className="strong" role="status">
                    {hint}
                  </p>
                )}
                {mayAct && (
                  <Group>
                    <Button
                      size="lg"
                      loading={isBusy}
                      onClick={() => onStart({ kind: isRemembered ? 'heading_reset' : USUAL })}
                    >
                      {t(isRemembered ? 'calibration.setDirections' : 'calibration.start')}
                    </Button>
                    {isRemembered && (
                      <Button size="lg" variant="default" loading={isBusy} onClick={() => onStart({ kind: USUAL })}>
                        {t('calibration.anew')}
                      </Button>
                    )}
                    {onClose && (
                      <Button size="lg" variant="default" onClick={onClose}>
                        {t('action.close')}
                      </Button>
                    )}
                  </Group>
                )}
                {mayAct && isRemembered && <p className="muted small">{t('calibration.rememberedElse')}</p>}
              </div>
            </div>
            {mayAct && (
              <>
                {worn.length > 0 && (
                  <details className="as-table guide-more">
                    <summary>{t('guide.cannot')}</summary>
                    <Others guides={worn} isBusy={isBusy} onStart={(kind) => onStart({ kind })} />
                  </details>
                )}
                {inHand.length > 0 && (
                  <details className="as-table guide-more">
                    <summary>{t('guide.devices')}</summary>
                    <InTheHand guides={inHand} placements={placements} isBusy={isBusy} onStart={onStart} />
                  </details>
                )}
              </>
            )}
          </section>
        );
      }}
    </QueryBoundary>
  );
}
