// A form whose content is not lost: leaving asks first, what was typed stays on this device and is offered on coming back.
import { Button, Group } from '@mantine/core';
import { lazy, Suspense, useCallback, useEffect, useRef, useState, type ReactNode } from 'react';
import { useBlocker } from 'react-router';
import { t } from '../../i18n';
import { readDraft, removeDraft, writeDraft } from '../../lib/editing/drafts';
import { hold, type Held } from '../../lib/editing/unsaved';
import { day } from '../../lib/format';
import { useSignedIn } from '../account/useSignedIn';
import { Notice } from '../Feedback';

const LeaveDialog = lazy(() => import('./LeaveDialog'));
const WRITTEN_AFTER_MS = 300;

export interface Unsaved {
  /** Shown at the head of the form: the offer of what was not saved, and the question before leaving. */
  guard: ReactNode;
  /** Called when the content was saved or given up, before the page is left. */
  release: () => void;
}

export function useUnsaved<T>({
  object,
  value,
  isChanged,
  onRestore,
}: {
  /** What is edited, by its kind and id. */
  object: string;
  /** All that was typed; it must survive JSON. */
  value: T;
  isChanged: boolean;
  onRestore: (value: T) => void;
}): Unsaved {
  const { account_id: account } = useSignedIn();
  const [offered, setOffered] = useState(() => readDraft<T>(account, object));
  // While the offer stands, what is stored is not this form's: it is neither written over nor removed.
  const isDecided = useRef(offered === null);
  const decide = () => {
    isDecided.current = true;
    setOffered(null);
  };
  const form = useRef<Held>({ isReleased: false });
  const latest = useRef({ value, isChanged });
  latest.current = { value, isChanged };
  const written = JSON.stringify(value);

  const write = useCallback(() => {
    // Released while it waited: saved, or no longer this person's.
    if (!latest.current.isChanged || form.current.isReleased || !isDecided.current) return;
    writeDraft(account, object, latest.current.value);
  }, [account, object]);

  // Before the form is let go below: an unmounted form writes what it held.
  useEffect(() => {
    window.addEventListener('pagehide', write);
    return () => {
      window.removeEventListener('pagehide', write);
      write();
    };
  }, [write]);
  useEffect(() => {
    if (!isChanged) return;
    const timer = setTimeout(write, WRITTEN_AFTER_MS);
    return () => clearTimeout(timer);
  }, [write, isChanged, written, offered]);
  useEffect(() => {
    if (!isChanged) return;
    const letGo = hold(form.current);
    const ask = (event: BeforeUnloadEvent) => {
      if (!form.current.isReleased) event.preventDefault();
    };
    window.addEventListener('beforeunload', ask);
    return () => {
      letGo();
      window.removeEventListener('beforeunload', ask);
      // Undone by hand: there is nothing to offer any more.
      if (!latest.current.isChanged && isDecided.current) removeDraft(account, object);
    };
  }, [account, object, isChanged]);

  const release = useCallback(() => {
    form.current.isReleased = true;
    if (isDecided.current) removeDraft(account, object);
    setOffered(null);
  }, [account, object]);
  const blocker = useBlocker(
    useCallback(
      ({
        currentLocation,
        nextLocation,
      }: {
        currentLocation: { pathname: string };
        nextLocation: { pathname: string };
      }) => latest.current.isChanged && !form.current.isReleased && currentLocation.pathname !== nextLocation.pathname,
      [],
    ),
  );
  const guard = (
    <>
      {offered && (
        <Notice>
          <p role="status">{t('unsaved.offer', { when: day(new Date(offered.at)) })}</p>
          <Group gap="md" mt="xs">
            <Button
              size="sm"
              onClick={() => {
                onRestore(offered.value);
                decide();
              }}
            >
              {t('unsaved.restore')}
            </Button>
            <Button
              size="sm"
              variant="default"
              onClick={() => {
                removeDraft(account, object);
                decide();
              }}
            >
              {t('unsaved.discard')}
            </Button>
          </Group>
        </Notice>
      )}
      {blocker.state === 'blocked' && (
        <Suspense fallback={null}>
          <LeaveDialog
            onStay={() => blocker.reset()}
            onLeave={offered ? undefined : () => blocker.proceed()}
            onDiscard={() => {
              release();
              blocker.proceed();
            }}
          />
        </Suspense>
      )}
    </>
  );
  return { guard, release };
}
