// What stands above a live session when something is wrong: only what is known here, and for how long.
import { IconPlugConnectedX } from '@tabler/icons-react';
import { useEffect, useState, type ReactNode } from 'react';
import { t } from '../../../i18n';
import type { SessionDetail } from '../../../api/types';
import { clockTimeS, duration, number } from '../../../lib/format';
import type { LiveSnapshot } from '../../../player/live';

/** The wall clock in s, brought up to date once a second while somebody needs it. */
function useNowS(isNeeded: boolean): number {
  const [nowS, setNowS] = useState(() => Date.now() / 1000);
  useEffect(() => {
    if (!isNeeded) return;
    setNowS(Date.now() / 1000);
    const timer = setInterval(() => setNowS(Date.now() / 1000), 1000);
    return () => clearInterval(timer);
  }, [isNeeded]);
  return nowS;
}

function Banner({ title, children }: { title: string; children: ReactNode }) {
  return (
    <div className="banner banner-alert" role="alert">
      <IconPlugConnectedX size={24} aria-hidden />
      <div>
        <p className="strong">{title}</p>
        {children}
      </div>
    </div>
  );
}

/** How long it lasts. It is read out with the banner only, not each second. */
function Lasting({ sinceS, nowS }: { sinceS: number; nowS: number }) {
  return (
    <span className="number" aria-live="off">
      {duration(Math.max(0, nowS - sinceS))}
    </span>
  );
}

/** What is known of a session that only HTTP tells of. */
type Known = Pick<SessionDetail, 'state' | 'packets_stored'>;

/** The cause, whom to ask, and what the service says all the same. */
function Blocked({ known }: { known: Known | undefined }) {
  return (
    <>
      <p>{t('live.blocked', { host: window.location.host })}</p>
      {known && (
        <p>
          {t('live.blockedState', {
            state: t(`sessionState.${known.state}`),
            count: number(known.packets_stored),
          })}
        </p>
      )}
      <p>{t('live.blockedText')}</p>
    </>
  );
}

interface LiveBannersProps {
  snapshot: LiveSnapshot;
  isLinkLost: boolean;
  /** The session as HTTP tells of it, asked for again while no socket gets through. */
  known?: Known;
}

/** One banner at most: out of reach, or silent sensors. */
export function LiveBanners({ snapshot, isLinkLost, known }: LiveBannersProps) {
  const { connection, lostSinceS, silentSinceS, state } = snapshot;
  const isLost = connection === 'lost' && lostSinceS !== null;
  const isSilent =
    !isLost && (isLinkLost || (silentSinceS !== null && (state?.state === 'ready' || state?.state === 'recording')));
  // Where no frame was ever seen here, nobody knows since when: only how long this page has waited.
  const [learntS, setLearntS] = useState<number | null>(null);
  useEffect(() => setLearntS(isSilent ? Date.now() / 1000 : null), [isSilent]);
  const nowS = useNowS(isLost || isSilent);
  if (connection === 'refused') {
    return (
      <Banner title={t('live.viewRefused')}>
        <p>{snapshot.problem}</p>
      </Banner>
    );
  }
  if (isLost) {
    return (
      <Banner title={t(snapshot.isBlocked ? 'live.blockedTitle' : 'live.viewLost', { time: clockTimeS(lostSinceS) })}>
        {snapshot.isBlocked ? <Blocked known={known} /> : <p>{t('live.viewLostText')}</p>}
        <p>{t('live.retrying')}</p>
        <p>
          {t('live.lostFor')} <Lasting sinceS={lostSinceS} nowS={nowS} />
        </p>
      </Banner>
    );
  }
  if (isSilent) {
    const sinceS = silentSinceS ?? learntS ?? nowS;
    return (
      <Banner title={silentSinceS === null ? t('live.noData') : t('live.linkLost', { time: clockTimeS(sinceS) })}>
        <p>
          {t(silentSinceS === null ? 'live.silentHere' : 'live.silentFor')} <Lasting sinceS={sinceS} nowS={nowS} />
        </p>
        <p>{t('live.linkLostText')}</p>
      </Banner>
    );
  }
  return null;
}
