import { useEffect, useState, useSyncExternalStore } from 'react';
import { socketUrl } from '../api/client';
import { LivePlayer, type LiveSnapshot } from './live';
import { ReplayPlayer } from './replay';
import type { Player, PlayerSnapshot } from './types';

/** The player of a live session; closed with the page. */
export function useLivePlayer(sessionId: string): LivePlayer | null {
  const [player, setPlayer] = useState<LivePlayer | null>(null);
  useEffect(() => {
    const opened = new LivePlayer({ url: socketUrl(`/ws/live/${sessionId}`) });
    setPlayer(opened);
    return () => {
      opened.close();
      setPlayer(null);
    };
  }, [sessionId]);
  return player;
}

/** The player of a stored session; a new one for each result. */
export function useReplayPlayer(
  sessionId: string,
  resultId: string | null,
  startS: number,
  endS: number,
): ReplayPlayer | null {
  const [player, setPlayer] = useState<ReplayPlayer | null>(null);
  useEffect(() => {
    if (!resultId || endS <= startS) return;
    const opened = new ReplayPlayer({ sessionId, resultId, startS, endS });
    setPlayer(opened);
    return () => {
      opened.close();
      setPlayer(null);
    };
  }, [sessionId, resultId, startS, endS]);
  return player;
}

export function useSnapshot(player: LivePlayer): LiveSnapshot;
export function useSnapshot(player: Player): PlayerSnapshot;
export function useSnapshot(player: Player): PlayerSnapshot {
  return useSyncExternalStore(player.subscribe, player.getSnapshot);
}

/** Session time for text that need not follow every picture. */
export function useClockText(player: Player, everyMs = 100): number {
  const [timeS, setTimeS] = useState(() => player.clock().timeS);
  const { epoch, isPlaying } = useSnapshot(player);
  useEffect(() => {
    setTimeS(player.clock().timeS);
    if (!isPlaying) return;
    const timer = setInterval(() => setTimeS(player.clock().timeS), everyMs);
    return () => clearInterval(timer);
  }, [player, epoch, isPlaying, everyMs]);
  return timeS;
}
