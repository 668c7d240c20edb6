import { Button } from '@mantine/core';
import { IconCheck, IconCopy } from '@tabler/icons-react';
import { useState } from 'react';
import { t } from '../i18n';
import './CopyBox.css';

/** Text that goes into another program: shown whole, copied with one button. */
export function CopyBox({ label, text }: { label: string; text: string }) {
  const [isCopied, setCopied] = useState(false);
  const copy = async () => {
    try {
      await navigator.clipboard.writeText(text);
      setCopied(true);
    } catch {
      // Without the right to the clipboard the text stays selectable.
      setCopied(false);
    }
  };
  return (
    <div className="copy-box">
      {/* eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex -- a scrolling region must be reachable by keyboard */}
      <pre aria-label={label} tabIndex={0} role="region">
        {text}
      </pre>
      <Button
        variant="default"
        size="sm"
        leftSection={isCopied ? <IconCheck size={17} aria-hidden /> : <IconCopy size={17} aria-hidden />}
        onClick={() => void copy()}
      >
        <span aria-live="polite">{isCopied ? t('action.copied') : t('action.copy')}</span>
      </Button>
    </div>
  );
}
