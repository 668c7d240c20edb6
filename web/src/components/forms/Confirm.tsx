import { Button } from '@mantine/core';
import { lazy, Suspense, useState } from 'react';

const ConfirmDialog = lazy(() => import('./ConfirmDialog'));

/** A small button whose deed cannot be undone: it asks first and says what will happen. */
export function Confirm({
  label,
  accessibleLabel,
  title,
  text,
  confirm,
  onConfirm,
}: {
  label: string;
  accessibleLabel?: string;
  title: string;
  text: string;
  confirm: string;
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
            onConfirm={onConfirm}
            onClose={() => setOpen(false)}
          />
        </Suspense>
      )}
    </>
  );
}
