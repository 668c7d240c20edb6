// Signing out where the service does not answer: said, noted, and done before anything else.
import { MantineProvider } from '@mantine/core';
import { QueryClient, QueryClientProvider } from '@tanstack/react-query';
import { act, fireEvent, render, screen } from '@testing-library/react';
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { wantedSignOut, wantSignOut } from '../../../src/api/signOut';
import { SignedOutFirst } from '../../../src/components/account/SignedOutFirst';

const NOBODY = { code: 'sign_in_required', message: 'sign in', details: {} };
const BUSY = { code: 'unavailable', message: 'later', details: {} };
const ME = { account_id: 'a', csrf_token: 'its own' };

type Answer = () => Promise<Response>;
const lost: Answer = () => Promise.reject(new TypeError('Failed to fetch'));
const never: Answer = () => new Promise(() => undefined);
const gives =
  (status: number, body: unknown = ''): Answer =>
  () =>
    Promise.resolve(status === 204 ? new Response(null, { status }) : Response.json(body, { status }));

let asked: string[];
let answers: Record<string, Answer>;
let ended: string[];

function open() {
  const client = new QueryClient();
  client.setQueryData(['patients', 'p'], { name: 'Ada' });
  render(
    <MantineProvider env="test">
      <QueryClientProvider client={client}>
        <SignedOutFirst onEnded={(reason) => ended.push(reason)}>
          <p>a patient&apos;s page</p>
        </SignedOutFirst>
      </QueryClientProvider>
    </MantineProvider>,
  );
  return client;
}

beforeEach(() => {
  vi.useFakeTimers();
  localStorage.clear();
  asked = [];
  ended = [];
  answers = { 'GET /api/me': gives(200, ME), 'POST /api/sign-out': gives(204) };
  vi.stubGlobal('fetch', (path: string, init: RequestInit) => {
    const what = `${init.method ?? 'GET'} ${path}`;
    asked.push(`${what} ${(init.headers as Record<string, string>)['X-CSRF-Token'] ?? ''}`.trim());
    init.signal?.addEventListener('abort', () => undefined);
    return Promise.race([
      (answers[what] ?? lost)(),
      new Promise<Response>((_, reject) =>
        init.signal?.addEventListener('abort', () => reject(new DOMException('', 'AbortError'))),
      ),
    ]);
  });
});
afterEach(() => {
  wantSignOut('asked');
  localStorage.clear();
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

const wait = (ms: number) => act(() => vi.advanceTimersByTimeAsync(ms));

it.each<[string, Record<string, Answer>]>([
  ['there is no link', { 'GET /api/me': lost, 'POST /api/sign-out': lost }],
  ['the link goes between two requests', { 'POST /api/sign-out': lost }],
  ['the service is busy', { 'GET /api/me': gives(503, BUSY) }],
  ['the service fails', { 'POST /api/sign-out': gives(500, BUSY) }],
  ['the service does not answer', { 'POST /api/sign-out': never }],
  ['a proxy answers instead', { 'GET /api/me': gives(401, 'portal') }],
])('says that somebody is still signed in when %s, and signs out as soon as it can', async (_, broken) => {
  answers = { ...answers, ...broken };
  const client = open();
  expect(screen.getByText("a patient's page")).toBeTruthy();
  act(() => wantSignOut('asked'));
  await wait(10_500);
  expect(screen.getByRole('alert').textContent).toContain('You are still signed in on this device');
  expect(screen.queryByText("a patient's page")).toBeNull();
  expect(client.getQueryData(['patients', 'p'])).toBeUndefined();
  expect(localStorage.getItem('telemotion.signOut')).toBe('asked');
  answers = { 'GET /api/me': gives(200, ME), 'POST /api/sign-out': gives(204) };
  await wait(16_000);
  expect(asked.at(-1)).toBe('POST /api/sign-out its own');
  expect(ended).toEqual(['asked']);
  expect(wantedSignOut()).toBeNull();
  expect(screen.getByText("a patient's page")).toBeTruthy();
});

it('tries again when asked to', async () => {
  answers['GET /api/me'] = lost;
  open();
  act(() => wantSignOut('idle'));
  await wait(10);
  answers['GET /api/me'] = gives(200, ME);
  fireEvent.click(screen.getByRole('button', { name: 'Try again' }));
  await wait(10);
  expect(ended).toEqual(['idle']);
});

it('does what was wanted before, in a page that is opened anew, before it asks or shows anything', async () => {
  localStorage.setItem('telemotion.signOut', 'asked');
  answers['GET /api/me'] = never;
  open();
  expect(screen.queryByText("a patient's page")).toBeNull();
  answers['GET /api/me'] = gives(200, ME);
  await wait(16_000);
  expect(asked).toEqual(['GET /api/me', 'GET /api/me', 'POST /api/sign-out its own']);
  expect(ended).toEqual(['asked']);
});

it('is done when the browser session has ended already', async () => {
  answers['GET /api/me'] = gives(401, NOBODY);
  open();
  act(() => wantSignOut('asked'));
  await wait(10);
  expect(wantedSignOut()).toBeNull();
  expect(asked).toEqual(['GET /api/me']);
});

it('ends no newer sign-in when another tab has signed out meanwhile', async () => {
  let answer: (response: Response) => void = () => undefined;
  answers['GET /api/me'] = () => new Promise((resolve) => (answer = resolve));
  open();
  act(() => wantSignOut('asked'));
  await wait(10);
  localStorage.removeItem('telemotion.signOut');
  act(() => void window.dispatchEvent(new StorageEvent('storage', { key: 'telemotion.signOut' })));
  answer(Response.json(ME));
  await wait(20_000);
  expect(asked).toEqual(['GET /api/me']);
  expect(screen.getByText("a patient's page")).toBeTruthy();
});
