import { Button } from '@mantine/core';
import { lazy, Suspense, useState } from 'react';

const ConfirmDialog = lazy(() => import('./ConfirmDialog'));

/** A small button whose deed is more than a click: it asks first and says what will happen. */
export function Confirm({
  label,
  accessibleLabel,
  title,
  text,
  confirm,
  isGrave = false,
  onConfirm,
}: {
  label: string;
  accessibleLabel?: string;
  title: string;
  text: string;
  confirm: string;
  /** Whether it cannot be undone, or is a danger. */
  isGrave?: boolean;
  onConfirm: () => void;
}) {
  const [isOpen, setOpen] = useState<boolean | null>(null);
  return (
    <>
      <Button
        variant="subtle"
        color="gray"
        size="compact-md"
        aria-label={accessibleLabel}
        onClick={() => setOpen(true)}
      >
        {label}
      </Button>
      {isOpen !== null && (
        <Suspense fallback={null}>
          <ConfirmDialog
            isOpen={isOpen}
            title={title}
            text={text}
            confirm={confirm}
            isGrave={isGrave}
            onConfirm={onConfirm}
            onClose={() => setOpen(false)}
          />
        </Suspense>
      )}
    </>
  );
}
