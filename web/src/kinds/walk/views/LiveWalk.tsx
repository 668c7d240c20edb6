// A walk while it happens: foot angle and stride of each foot; on instrumented shoes what each carries, and balance.
import { IconAlertTriangle, IconCheck, IconClock } from '@tabler/icons-react';
import { useEffect, useState } from 'react';
import { t } from '../../../i18n';
import { GRAVITY, hasForces, isUsable, readWalk, type FootReading, type WalkReading } from '../forces';
import { number, quantity } from '../../../lib/format';
import type { Player } from '../../../player/types';
import './LiveWalk.css';

const REFRESH_MS = 250;

function State({ foot }: { foot: FootReading }) {
  if (foot.state === null) return null;
  const Icon = foot.state === 'measured' ? IconCheck : isUsable(foot.state) ? IconClock : IconAlertTriangle;
  return (
    <span className={isUsable(foot.state) ? 'muted small' : 'alert-text small'} style={{ display: 'block' }}>
      <Icon size={16} aria-hidden /> {t(`forces.state.${foot.state}`)}
    </span>
  );
}

/** What a foot carries, as a part of the body's weight; in newtons until that is known. */
function Load({ foot, massKg }: { foot: FootReading; massKg: number }) {
  const share = foot.loadN / (massKg * GRAVITY);
  const text = Number.isFinite(share)
    ? `${number(100 * Math.max(share, 0))} %`
    : Number.isFinite(foot.loadN)
      ? `${number(Math.max(foot.loadN, 0))} N`
      : '–';
  const full = Number.isFinite(share) ? Math.min(Math.max(share / 1.3, 0), 1) : 0;
  return (
    <>
      <span className="number strong" data-testid={`load-${foot.side}`}>
        {text}
      </span>
      <span className="load-bar" aria-hidden>
        <span className={`load-${foot.side}`} style={{ width: `${100 * full}%` }} />
      </span>
    </>
  );
}

export function LiveWalk({ player, scalars, delayS }: { player: Player; scalars: readonly string[]; delayS: number }) {
  const [reading, setReading] = useState<WalkReading | null>(null);
  useEffect(() => {
    const timer = setInterval(() => setReading(readWalk(player)), REFRESH_MS);
    return () => clearInterval(timer);
  }, [player]);
  if (!reading) return null;
  const withForces = hasForces(scalars);
  const worn = reading.feet.filter((foot) => scalars.includes(`foot_${foot.side}_stance`));
  const isBalanced = Number.isFinite(reading.heightM);
  return (
    <section className="card" aria-labelledby="live-walk">
      <div className="card-head">
        <h2 id="live-walk">{t('forces.title')}</h2>
        <span className="muted small" data-testid="shown-late">
          {t('forces.late', { seconds: number(delayS, 1) })}
        </span>
      </div>
      <ul className="plain-list lines">
        {worn.map((foot) => (
          <li key={foot.side}>
            <span className="strong">{t(`forces.${foot.side}`)}</span>{' '}
            {withForces && <Load foot={foot} massKg={reading.massKg} />}
            <span className="small" style={{ display: 'block' }}>
              {t('forces.step', { stride: quantity(foot.strideM, 'm'), angle: quantity(foot.toeOutRad, 'rad') })}
            </span>
            {withForces && <State foot={foot} />}
          </li>
        ))}
      </ul>
      {withForces && (
        <dl className="facts live-balance">
          <dt>{t('forces.mass')}</dt>
          <dd className="number">{Number.isFinite(reading.massKg) ? `${number(reading.massKg)} kg` : '–'}</dd>
          <dt>{t('forces.height')}</dt>
          <dd className="number" data-testid="centre-of-mass">
            {quantity(reading.heightM, 'm')}
          </dd>
          <dt>{t('forces.margin')}</dt>
          <dd className="number">{quantity(reading.marginM, 'm')}</dd>
        </dl>
      )}
      {withForces && !isBalanced && (
        <p className="muted small">{t(worn.every((foot) => isUsable(foot.state)) ? 'forces.soon' : 'forces.notNow')}</p>
      )}
    </section>
  );
}
