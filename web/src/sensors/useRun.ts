// A run and its state, for components.
import { useState, useSyncExternalStore } from 'react';
import { SensorRun, type RunSnapshot } from './run';

const NOTHING = () => () => undefined;

/** The run of this session on this page, its state, and how to show another. */
export function useRun(sessionId: string): [SensorRun | null, RunSnapshot | null, (run: SensorRun | null) => void] {
  const [run, setRun] = useState<SensorRun | null>(() => SensorRun.of(sessionId));
  const snapshot = useSyncExternalStore(run?.subscribe ?? NOTHING, () => run?.getSnapshot() ?? null);
  return [run, snapshot, setRun];
}
