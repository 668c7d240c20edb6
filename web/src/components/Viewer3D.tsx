// The 3D view: a page of the service in a frame, opened for this person and closed with the page.
import { Button, useComputedColorScheme } from '@mantine/core';
import { IconPlugConnectedX, IconUser } from '@tabler/icons-react';
import { useQuery } from '@tanstack/react-query';
import { lazy, Suspense, useEffect, useRef, useState, useSyncExternalStore, type RefObject } from 'react';
import { ofSession } from '../api/address';
import { api, ApiError } from '../api/client';
import type { ViewIn } from '../api/types';
import { currentLanguage, t } from '../i18n';
import { listenForUse } from '../lib/browser/idle';
import { passKeysOn } from '../lib/browser/keys';
import { canDraw3D, hasDrawn, whenLostForGood } from '../lib/browser/webgl';
import type { Player } from '../player/types';
import { NO_VIEW, ViewLink, type GhostChoice, type ViewSnapshot } from '../player/view';
import { Problem } from './Feedback';
import type { Near, Preset } from './CameraBar';
import './Viewer3D.css';

// A patient who exercises does not turn the picture: her page loads no buttons for it.
const CameraBar = lazy(() => import('./CameraBar'));
const FlatFigure = lazy(() => import('../pictures/flat/FlatFigure'));

export interface Viewer3DProps {
  sessionId: string;
  request: ViewIn;
  title: string;
  /** Steers a replay; a live view steers itself. Where nothing can be drawn in 3D, its frames are drawn flat. */
  player?: Player | null;
  ghost?: GhostChoice;
  isReady?: boolean;
  /** What the nearest point of view shows. */
  near?: Near;
  onShown?: (shown: ViewSnapshot['shown']) => void;
  /** From where it is looked at when it opens. */
  from?: Preset;
  /** Without the buttons that turn it: for whoever has no hand free. */
  isPlain?: boolean;
}

const never = () => () => undefined;
/** While the service is out of reach it is asked for a view so often. */
const ASK_AGAIN_MS = 2500;
/** A view that is refused sooner than this after it was opened is not opened again without a hand. */
const LEAST_LIFE_MS = 10_000;
const isOutOfReach = (error: unknown) =>
  error instanceof ApiError && (error.status === 0 || error.status === 502 || error.status === 503);

const LOOK_MS = 200;
/** A view that is open for so long is shown, whatever is in it. */
const LONGEST_WAIT_MS = 8000;

/** Whether something stands in the view of a frame; false again for the frame of another connection. */
function useDrawn(frame: RefObject<HTMLIFrameElement | null>, key: string, isOpen: boolean): boolean {
  const [drawn, setDrawn] = useState('');
  useEffect(() => {
    if (!isOpen) return;
    const began = performance.now();
    const timer = setInterval(() => {
      if (!hasDrawn(frame.current) && performance.now() - began < LONGEST_WAIT_MS) return;
      clearInterval(timer);
      setDrawn(key);
    }, LOOK_MS);
    return () => clearInterval(timer);
  }, [frame, key, isOpen]);
  return drawn === key;
}

/** The body in 3D, or flat where this browser cannot. */
export function Viewer3D(props: Viewer3DProps) {
  const [can] = useState(canDraw3D);
  const [isLost, setLost] = useState(false);
  useEffect(() => {
    if (!isLost) return;
    // Whoever comes back may have the graphics card again.
    const tryAgain = () => document.visibilityState === 'visible' && setLost(!canDraw3D());
    document.addEventListener('visibilitychange', tryAgain);
    return () => document.removeEventListener('visibilitychange', tryAgain);
  }, [isLost]);
  if (can && !isLost) return <Solid {...props} onLost={() => setLost(true)} />;
  return (
    <Suspense fallback={<div className="viewer-box flat" />}>
      {props.player && <FlatFigure player={props.player} title={props.title} isPlain={props.isPlain} />}
    </Suspense>
  );
}

function Solid({
  sessionId,
  request,
  title,
  player = null,
  ghost,
  isReady = true,
  onShown,
  near = 'arm',
  from,
  isPlain,
  onLost,
}: Viewer3DProps & { onLost: () => void }) {
  const scheme = useComputedColorScheme('light');
  const language = currentLanguage() === 'de' ? 'de' : 'en';
  const view = useQuery({
    queryKey: [
      'view',
      sessionId,
      language,
      request.mode,
      request.result_id ?? null,
      request.template_version_id ?? null,
      request.markers_id ?? null,
    ],
    queryFn: () =>
      api.post('/api/sessions/{session_id}/views', { ...ofSession(sessionId), body: { ...request, language } }),
    enabled: isReady,
    staleTime: Infinity,
    gcTime: 0,
    networkMode: 'always',
    retry: (_, error) => isOutOfReach(error),
    retryDelay: ASK_AGAIN_MS,
  });
  const [link, setLink] = useState<ViewLink | null>(null);
  const controlPath = view.data?.control_path;
  const needsPlayer = request.mode === 'replay';

  useEffect(() => {
    if (!controlPath || (needsPlayer && !player)) return;
    const opened = new ViewLink(controlPath, needsPlayer ? player : null);
    setLink(opened);
    return () => {
      opened.close();
      setLink(null);
    };
  }, [player, controlPath, needsPlayer]);
  useEffect(() => {
    if (ghost) link?.setGhost(ghost);
  }, [link, ghost]);
  useEffect(() => link?.setTheme(scheme), [link, scheme]);

  const { status, reason, problem, shown, isBlocked, connections } = useSyncExternalStore(
    link?.subscribe ?? never,
    link?.getSnapshot ?? (() => NO_VIEW),
  );
  useEffect(() => onShown?.(shown), [shown, onShown]);
  useEffect(() => {
    if (from && status === 'open') link?.camera({ preset: from });
  }, [link, from, status]);
  // A service that was started again knows nothing of this view: a new one is opened without a hand.
  const { refetch, dataUpdatedAt } = view;
  const frame = useRef<HTMLIFrameElement>(null);
  // The frame has a socket of its own, which may not know that it was cut: with a new connection it begins anew.
  const frameKey = `${view.data?.id}-${Math.max(1, connections)}`;
  const isDrawn = useDrawn(frame, frameKey, status === 'open');
  useEffect(() => {
    if (status === 'refused' && Date.now() - dataUpdatedAt > LEAST_LIFE_MS) void refetch();
  }, [status, refetch, dataUpdatedAt]);

  if (view.error) {
    return (
      <div className="viewer viewer-problem">
        <Problem error={view.error} title={t('viewer.failed')} onRetry={() => void view.refetch()} />
      </div>
    );
  }
  const isUnreached = view.isFetching && view.failureCount > 0;
  const isGone = status === 'lost' || status === 'refused' || isUnreached;
  const words =
    problem ||
    (isBlocked
      ? t('viewer.blocked')
      : isUnreached || status === 'lost'
        ? t('viewer.lost')
        : reason || t('viewer.ended'));
  return (
    <div className="viewer-box">
      <div className={isGone ? 'viewer viewer-gone' : 'viewer'} data-testid="viewer">
        {view.data && (
          <iframe
            ref={frame}
            key={frameKey}
            src={view.data.page_path}
            title={title}
            allow="fullscreen"
            onLoad={(event) => {
              passKeysOn(event.currentTarget);
              whenLostForGood(event.currentTarget, onLost);
              if (event.currentTarget.contentWindow) listenForUse(event.currentTarget.contentWindow);
            }}
          />
        )}
        {!isDrawn && (
          <div className="viewer-coming" role="status">
            <IconUser size={54} stroke={1.2} aria-hidden />
            {!isGone && <span>{t('viewer.coming')}</span>}
          </div>
        )}
        {(isGone || problem) && (
          <div className="viewer-banner" role="alert">
            <IconPlugConnectedX size={20} aria-hidden />
            <span>{words}</span>
            {status === 'refused' && !view.isFetching && (
              <Button size="compact-md" variant="default" onClick={() => void view.refetch()}>
                {t('viewer.reopen')}
              </Button>
            )}
          </div>
        )}
      </div>
      {!isPlain && (
        <Suspense fallback={<div className="camera-bar" />}>
          <CameraBar link={link} near={near} />
        </Suspense>
      )}
    </div>
  );
}
