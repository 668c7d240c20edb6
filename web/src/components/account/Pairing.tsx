import { Button, Group } from '@mantine/core';
import type { PairingCode } from '../../api/types';
import { t } from '../../i18n';
import { clockTime } from '../../lib/format';
import { QrCode } from './QrCode';

/** The code that the gateway exchanges for its token, to type and to scan. */
export function Pairing({
  made,
  help = (time) => t('device.pairHelp', { time }),
  onDone,
}: {
  made: PairingCode;
  /** What to do with it, until when. */
  help?: (time: string) => string;
  onDone: () => void;
}) {
  const readable = `${made.code.slice(0, 4)} ${made.code.slice(4)}`;
  return (
    <div className="stack">
      <p>{help(clockTime(made.expires_at))}</p>
      <p className="pairing-code number" aria-label={t('device.pairCode')}>
        {readable}
      </p>
      <QrCode
        text={`telemotion:pair?server=${encodeURIComponent(window.location.origin)}&code=${made.code}`}
        label={t('device.pairQr')}
      />
      <Group justify="flex-end">
        <Button onClick={onDone}>{t('action.close')}</Button>
      </Group>
    </div>
  );
}
