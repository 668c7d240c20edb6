// The calibration that is in force, with a new one and a new heading at hand.
import { Button, Group } from '@mantine/core';
import type { Calibration, Placement } from '../../api/types';
import { Problem } from '../../components/Feedback';
import { t, tOr } from '../../i18n';
import { reasonsOf, wornLimbs } from '../../lib/calibration';
import { scoreText } from '../session/live/Calibration';
import { useCalibrating } from './useCalibrating';
import './InForce.css';

export function InForce({
  sessionId,
  calibration,
  placements,
  onAgain,
}: {
  sessionId: string;
  calibration: Calibration;
  placements: readonly Placement[];
  onAgain: () => void;
}) {
  const { start, error } = useCalibrating(sessionId);
  const { isUnchecked, reasons } = reasonsOf(calibration);
  return (
    <section className="card in-force" aria-labelledby="in-force">
      <div>
        <div className="card-head">
          <h2 id="in-force">{t('details.calibration')}</h2>
          <Button className="end" size="sm" variant="default" onClick={onAgain}>
            {t('calibration.again')}
          </Button>
        </div>
        <p>{scoreText(calibration.score, isUnchecked)}</p>
        {reasons.map((reason) => (
          <p key={reason}>{reason}</p>
        ))}
        <p className="muted small">
          {tOr(`calibration.method.${calibration.method}`, calibration.method.replaceAll('_', ' '))}.{' '}
          {t('calibration.inForce')}
        </p>
      </div>
      <div>
        <p className="strong">{t('heading.title')}</p>
        <p className="muted small">{t('heading.help')}</p>
        <Group gap="xs" mt={8}>
          {wornLimbs(placements).map((limb) => (
            <Button
              key={limb}
              size="sm"
              variant="default"
              loading={start.isPending && start.variables.limbs?.[0] === limb}
              onClick={() => start.mutate({ kind: 'heading_reset', limbs: [limb] })}
              aria-label={t('heading.reset', { limb: t(`limb.${limb}`) })}
            >
              {t(`limb.${limb}`)}
            </Button>
          ))}
        </Group>
      </div>
      {error && <Problem error={error} />}
    </section>
  );
}
