// Everything held about a patient as one file: it is made while it is sent, and the page says how far it is.
import { Button } from '@mantine/core';
import { IconCircleCheckFilled, IconDownload } from '@tabler/icons-react';
import { useEffect, useRef, useState } from 'react';
import { address, ofPatient, type Address } from '../../api/address';
import { api, ApiError } from '../../api/client';
import { t } from '../../i18n';
import { bytes } from '../../lib/format';
import { Notice, Problem } from '../Feedback';
import './ExportButton.css';

type State = { kind: 'idle' | 'making' | 'ready'; size: number } | { kind: 'failed'; error: unknown };

/** Give a file to the browser's downloads, as a link would. */
function save(pieces: Uint8Array<ArrayBuffer>[], name: string): void {
  const address = URL.createObjectURL(new Blob(pieces, { type: 'application/zip' }));
  const link = document.createElement('a');
  link.href = address;
  link.download = name;
  link.click();
  // The download has begun by then.
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}

async function received(at: Address<unknown>, signal: AbortSignal, onSize: (size: number) => void) {
  const response = await api.stream(at, signal);
  const name = /filename="([^"]+)"/.exec(response.headers.get('Content-Disposition') ?? '')?.[1] ?? 'patient.zip';
  const pieces: Uint8Array<ArrayBuffer>[] = [];
  let size = 0;
  const reader = response.body!.getReader();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return { pieces, name, size };
    pieces.push(value);
    size += value.byteLength;
    onSize(size);
  }
}

/** The archive of everything, as the browser downloads it. */
export function ExportButton({ patientId, size }: { patientId: string; size?: 'sm' | 'lg' }) {
  const at = address('/api/patients/{patient_id}/export', ofPatient(patientId));
  const [state, setState] = useState<State>({ kind: 'idle', size: 0 });
  const running = useRef<AbortController>(undefined);
  useEffect(() => () => running.current?.abort(), []);
  const isMaking = state.kind === 'making';
  const begin = () => {
    const mine = new AbortController();
    running.current = mine;
    setState({ kind: 'making', size: 0 });
    received(at, mine.signal, (size) => setState({ kind: 'making', size })).then(
      ({ pieces, name, size }) => {
        save(pieces, name);
        setState({ kind: 'ready', size });
      },
      (error: unknown) => {
        if (mine.signal.aborted) return setState({ kind: 'idle', size: 0 });
        // What the service refuses it says itself; a body that ends too early has no words.
        setState({ kind: 'failed', error: error instanceof ApiError ? error : new Error(t('data.exportBroken')) });
      },
    );
  };
  return (
    <div className="export">
      <Button
        component="a"
        href={at}
        download
        size={size}
        variant="default"
        loading={isMaking}
        leftSection={<IconDownload size={18} aria-hidden />}
        onClick={(event) => {
          event.preventDefault();
          if (!isMaking) begin();
        }}
      >
        {t('data.export')}
      </Button>
      {isMaking && (
        <Button variant="subtle" color="gray" size={size} onClick={() => running.current?.abort()}>
          {t('action.cancel')}
        </Button>
      )}
      <div role="status">
        {isMaking && <p>{t('data.exportMaking', { size: bytes(state.size) })}</p>}
        {state.kind === 'ready' && (
          <Notice icon={<IconCircleCheckFilled size={22} aria-hidden />}>
            {t('data.exportReady', { size: bytes(state.size) })}
          </Notice>
        )}
      </div>
      {state.kind === 'failed' && <Problem error={state.error} onRetry={begin} />}
    </div>
  );
}
