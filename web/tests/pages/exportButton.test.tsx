// Downloading everything: how far it is, that it is ready, and what went wrong.
import { screen, waitFor } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { ExportButton } from '../../src/components/account/ExportButton';
import { renderPage } from './render';

const PATH = '/api/patients/p/export';
let saved: { name: string; size: number }[];
let body: ReadableStreamDefaultController<Uint8Array>;

function open(answer?: () => Response) {
  renderPage(<ExportButton patientId="p" />, { answers: {} });
  const stream = new ReadableStream<Uint8Array>({ start: (controller) => void (body = controller) });
  const headers = { 'Content-Disposition': 'attachment; filename="patient-p.zip"' };
  vi.stubGlobal('fetch', (path: string, init: RequestInit) => {
    expect(path).toBe(PATH);
    init.signal?.addEventListener('abort', () => body.error(new DOMException('', 'AbortError')));
    return Promise.resolve(answer?.() ?? new Response(stream, { headers }));
  });
}

beforeEach(() => {
  saved = [];
  let made: Blob | undefined;
  // jsdom makes no addresses of blobs.
  URL.createObjectURL = (blob) => ((made = blob as Blob), 'blob:made');
  vi.spyOn(HTMLAnchorElement.prototype, 'click').mockImplementation(function (this: HTMLAnchorElement) {
    saved.push({ name: this.download, size: made?.size ?? 0 });
  });
});
afterEach(() => {
  vi.restoreAllMocks();
  vi.unstubAllGlobals();
});

const press = () => userEvent.click(screen.getByRole('link', { name: 'Download everything' }));

it('says how much has come, then that it is ready, and saves the whole of it', async () => {
  open();
  await press();
  const status = screen.getByRole('status');
  expect(status.textContent).toContain('being made and downloaded: 0');
  body.enqueue(new Uint8Array(1_500_000));
  await waitFor(() => expect(status.textContent).toContain('1.5 MB so far'));
  expect(saved).toEqual([]);
  body.enqueue(new Uint8Array(500_000));
  body.close();
  await waitFor(() => expect(status.textContent).toContain('Ready: 2.0 MB'));
  expect(saved).toEqual([{ name: 'patient-p.zip', size: 2_000_000 }]);
});

it('saves nothing of a file that breaks off, and says so', async () => {
  open();
  await press();
  body.enqueue(new Uint8Array(1000));
  body.error(new TypeError('network error'));
  expect((await screen.findByRole('alert')).textContent).toContain('The download broke off. Nothing was saved');
  expect(saved).toEqual([]);
});

it('says why the service refuses', async () => {
  const refused = { code: 'limit_reached', message: 'Too many exports are being made.', details: {} };
  open(() => Response.json(refused, { status: 429 }));
  await press();
  expect((await screen.findByRole('alert')).textContent).toContain('Too many exports are being made.');
});

it('is given up when asked', async () => {
  open();
  await press();
  body.enqueue(new Uint8Array(1000));
  await userEvent.click(await screen.findByRole('button', { name: 'Cancel' }));
  await waitFor(() => expect(screen.getByRole('status').textContent).toBe(''));
  expect(saved).toEqual([]);
  expect(screen.queryByRole('alert')).toBeNull();
});
