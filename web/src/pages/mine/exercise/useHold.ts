// What holds an exercise up: the patient's own wish at once, whatever the network does, and what the service says.
import { useMutation } from '@tanstack/react-query';
import { useEffect, useState } from 'react';
import { ofSession } from '../../../api/address';
import { byHand } from '../../../api/client';
import type { GuidanceMessage } from '../../../api/types';

type Command = 'pause' | 'resume' | 'pain' | 'stop';
/** Why nothing is counted now; each has its own words. */
export type Held =
  'person' | 'finish' | 'pain' | 'limit' | 'done' | 'set' | 'enough' | 'time' | 'lost' | 'wrong_in_a_row';

const BY_SERVICE: Partial<Record<GuidanceMessage['cause'] & string, Held>> = {
  person: 'person',
  pain: 'pain',
  limit: 'limit',
  valid_count: 'done',
  set: 'set',
  attempt_count: 'enough',
  time: 'time',
  lost: 'lost',
  unsure: 'lost',
  wrong_in_a_row: 'wrong_in_a_row',
};

/** The reason that the service gives, in the page's words; null while the exercise goes on. */
export function heldBy(guidance: GuidanceMessage | null): Held | null {
  if (!guidance || (guidance.status !== 'paused' && guidance.status !== 'stopped')) return null;
  return BY_SERVICE[guidance.cause || 'person'] ?? 'person';
}

export interface Hold {
  held: Held | null;
  /** The service could not be reached. */
  isUnreached: boolean;
  isBusy: boolean;
  /** The service has stored that it hurt. */
  isPainKnown: boolean;
  hold: (wish: 'person' | 'finish' | 'pain') => void;
  goOn: () => void;
}

const AGAIN_MS = 2000;

export function useHold(sessionId: string, guidance: GuidanceMessage | null): Hold {
  const [wish, setWish] = useState<'person' | 'finish' | 'pain' | null>(null);
  const { mutate, isPending, isError, variables } = useMutation({
    mutationFn: (command: Command) =>
      byHand.post('/api/sessions/{session_id}/guidance', { ...ofSession(sessionId), body: { command } }),
    onSuccess: (_, command) => {
      if (command === 'resume') setWish(null);
    },
  });
  // What did not arrive is sent again until it does: a pain that nobody hears of helps nobody.
  useEffect(() => {
    if (!isError || wish === null || variables === 'resume') return;
    const again = setTimeout(() => mutate(wish === 'pain' ? 'pain' : 'pause'), AGAIN_MS);
    return () => clearTimeout(again);
  }, [isError, isPending, wish, variables, mutate]);
  const said = heldBy(guidance);
  // What the patient pressed comes first; pain that another page reported is never hidden by a pause.
  const held = wish && said !== 'pain' ? wish : (said ?? wish);
  return {
    held,
    isUnreached: isError && (wish !== null || variables === 'resume'),
    isBusy: isPending,
    isPainKnown: guidance?.cause === 'pain',
    hold: (next) => {
      setWish(next);
      mutate(next === 'pain' ? 'pain' : 'pause');
    },
    goOn: () => mutate('resume'),
  };
}
