// The 3D view: a page of the service in a frame, opened for this person and closed with the page.
import { Button, Skeleton, useComputedColorScheme } from '@mantine/core';
import { IconPlugConnectedX } from '@tabler/icons-react';
import { useQuery } from '@tanstack/react-query';
import { lazy, Suspense, useEffect, useRef, useState, useSyncExternalStore } from 'react';
import { api } from '../api/client';
import type { CameraCommand, View, ViewIn } from '../api/types';
import { currentLanguage, t } from '../i18n';
import { listenForUse } from '../lib/browser/idle';
import { passKeysOn } from '../lib/browser/keys';
import type { Player } from '../player/types';
import { ViewLink, type GhostChoice, type ViewSnapshot } from '../player/view';
import { Problem } from './Feedback';

// A patient who exercises does not turn the picture: her page loads no buttons for it.
const CameraBar = lazy(() => import('./CameraBar'));

export interface Viewer3DProps {
  sessionId: string;
  request: ViewIn;
  title: string;
  /** Steers a replay; a live view steers itself. */
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

export type Near = 'arm' | 'leg' | 'feet' | 'marker' | 'modules';
export type Preset = NonNullable<CameraCommand['preset']>;
const NOTHING: ViewSnapshot = { status: 'connecting', problem: '', shown: null };
const never = () => () => undefined;

export function Viewer3D({
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
}: Viewer3DProps) {
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
    queryFn: () => api.post<View>(`/api/sessions/${sessionId}/views`, { ...request, language }),
    enabled: isReady,
    staleTime: Infinity,
    gcTime: 0,
    retry: false,
  });
  const [link, setLink] = useState<ViewLink | null>(null);
  const controlPath = view.data?.control_path;
  const needsPlayer = request.mode === 'replay';

  useEffect(() => {
    if (!controlPath || (needsPlayer && !player)) return;
    const opened = new ViewLink(controlPath, player);
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

  const { status, problem, shown } = useSyncExternalStore(
    link?.subscribe ?? never,
    link?.getSnapshot ?? (() => NOTHING),
  );
  useEffect(() => onShown?.(shown), [shown, onShown]);
  useEffect(() => {
    if (from && status === 'open') link?.camera({ preset: from });
  }, [link, from, status]);
  // A service that was started again knows nothing of this view: after a loss a new one is opened without a hand.
  const wasLost = useRef(false);
  const { refetch } = view;
  useEffect(() => {
    if (status === 'lost') wasLost.current = true;
    else if (status === 'refused' && wasLost.current) {
      wasLost.current = false;
      void refetch();
    }
  }, [status, refetch]);

  if (view.error) {
    return (
      <div className="viewer viewer-problem">
        <Problem error={view.error} title={t('viewer.failed')} onRetry={() => void view.refetch()} />
      </div>
    );
  }
  const isGone = status === 'lost' || status === 'refused';
  return (
    <div className="viewer-box">
      <div className={isGone ? 'viewer viewer-gone' : 'viewer'} data-testid="viewer">
        {view.data ? (
          <iframe
            key={view.data.id}
            src={view.data.page_path}
            title={title}
            allow="fullscreen"
            onLoad={(event) => {
              passKeysOn(event.currentTarget);
              if (event.currentTarget.contentWindow) listenForUse(event.currentTarget.contentWindow);
            }}
          />
        ) : (
          <Skeleton height="100%" radius={0} animate={false} role="status" aria-label={t('state.loading')} />
        )}
        {(isGone || problem) && (
          <div className="viewer-banner" role="alert">
            <IconPlugConnectedX size={20} aria-hidden />
            <span>{problem || (status === 'lost' ? t('viewer.lost') : t('viewer.ended'))}</span>
            {status === 'refused' && (
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
