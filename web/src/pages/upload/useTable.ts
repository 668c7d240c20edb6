// How the chosen table is read: guessed by the service from its beginning, looked at again after every change; nothing is stored there.
import { useMutation } from '@tanstack/react-query';
import { useEffect, useRef, useState } from 'react';
import { byHand } from '../../api/client';
import type { GuessedMapping, PreviewIn, TablePreview } from '../../api/types';
import type { Pipeline } from '../../lib/csv';
import { beginningOf, laterOf } from './beginning';

/** So long after the last change is it looked at again. */
const QUIET_MS = 350;

interface Asked {
  file: File;
  pipeline: Pipeline | null;
  mapping?: GuessedMapping;
  hemisphere?: PreviewIn['hemisphere'];
  turn: number;
}

export interface Table {
  /** The newest answer to a mapping, while another is asked for as well. */
  seen: TablePreview | null;
  mapping: GuessedMapping | null;
  /** The file is looked at for the first time, or for another pipeline. */
  isLooking: boolean;
  /** A change is on its way. */
  isChanging: boolean;
  error: Error | null;
  lookAt: (file: File, pipeline: Pipeline | null, mapping?: GuessedMapping) => void;
  change: (file: File, mapping: GuessedMapping, hemisphere: PreviewIn['hemisphere']) => void;
  forget: () => void;
}

export function useTable(onFound: (found: TablePreview) => void): Table {
  const [seen, setSeen] = useState<TablePreview | null>(null);
  const [mapping, setMapping] = useState<GuessedMapping | null>(null);
  // The answer to an earlier file or choice must not overwrite that to the newest.
  const newest = useRef(0);
  const waiting = useRef<ReturnType<typeof setTimeout>>(undefined);
  const pipeline = useRef<Pipeline | null>(null);
  useEffect(() => () => clearTimeout(waiting.current), []);
  const ask = async ({ file, pipeline: wanted, mapping: said, hemisphere }: Asked) =>
    byHand.post('/api/uploads/preview', {
      body: {
        file_name: file.name.slice(-200),
        beginning: await beginningOf(file),
        later: await laterOf(file),
        pipeline: wanted,
        ...(said && { mapping: said }),
        ...(hemisphere && { hemisphere }),
      },
    });
  const look = useMutation({
    mutationFn: ask,
    onSuccess: (found, { turn }) => {
      if (turn !== newest.current) return;
      setSeen(found);
      setMapping(found.mapping ?? { signals: [] });
      onFound(found);
    },
  });
  const follow = useMutation({
    mutationFn: ask,
    onSuccess: (found, { turn }) => {
      if (turn === newest.current) setSeen(found);
    },
  });
  const next = () => {
    clearTimeout(waiting.current);
    newest.current += 1;
    return newest.current;
  };
  return {
    seen,
    mapping,
    isLooking: look.isPending,
    isChanging: follow.isPending,
    error: look.error ?? follow.error,
    lookAt: (file, wanted, said) => {
      pipeline.current = wanted;
      follow.reset();
      look.mutate({ file, pipeline: wanted, mapping: said, turn: next() });
    },
    change: (file, said, hemisphere) => {
      setMapping(said);
      const turn = next();
      waiting.current = setTimeout(
        () => follow.mutate({ file, pipeline: pipeline.current, mapping: said, hemisphere, turn }),
        QUIET_MS,
      );
    },
    forget: () => {
      next();
      look.reset();
      follow.reset();
      setSeen(null);
      setMapping(null);
    },
  };
}
