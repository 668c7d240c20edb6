import { MantineProvider } from '@mantine/core';
import { act, render, screen } from '@testing-library/react';
import { QueryClient, QueryClientProvider } from '@tanstack/react-query';
import { createMemoryRouter, RouterProvider } from 'react-router';
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { SignedOutFirst } from '../../../src/components/account/SignedOutFirst';
import type { SignOutReason } from '../../../src/api/signOut';
import { IdleWatch } from '../../../src/components/account/IdleWatch';
import { idleSeconds } from '../../../src/lib/browser/idle';

const asked: string[] = [];

beforeEach(() => {
  vi.useFakeTimers();
  localStorage.clear();
  asked.length = 0;
  vi.stubGlobal('fetch', (path: string, init: RequestInit) => {
    asked.push(`${init.method ?? 'GET'} ${path} ${(init.headers as Record<string, string>)['X-Idle-Seconds']}`);
    return Promise.resolve(new Response('{}', { status: 200 }));
  });
  const router = createMemoryRouter([
    { path: '/', element: <IdleWatch minutes={10} /> },
    { path: '/sign-in', element: <p>signed out</p> },
  ]);
  const onEnded = (reason: SignOutReason) => void router.navigate(`/sign-in?ended=${reason}`, { replace: true });
  render(
    <MantineProvider env="test">
      <QueryClientProvider client={new QueryClient()}>
        <SignedOutFirst onEnded={onEnded}>
          <RouterProvider router={router} />
        </SignedOutFirst>
      </QueryClientProvider>
    </MantineProvider>,
  );
  act(() => void window.dispatchEvent(new Event('pointerdown')));
});

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

const wait = (seconds: number) => act(() => vi.advanceTimersByTimeAsync(seconds * 1000));

it('warns a page that nobody uses, then signs it out and says so', async () => {
  await wait(470);
  expect(screen.queryByRole('alert')).toBeNull();
  await wait(20);
  expect(screen.getByRole('alert').textContent).toContain('nobody has used this page');
  await wait(120);
  expect(screen.getByText('signed out')).toBeTruthy();
  expect(asked.at(-1)).toMatch(/^POST \/api\/sign-out/);
});

it('takes the warning away when somebody is there, and tells the service', async () => {
  await wait(500);
  act(() => void window.dispatchEvent(new Event('keydown')));
  expect(screen.queryByRole('alert')).toBeNull();
  expect(idleSeconds()).toBe(0);
  expect(asked.at(-1)).toBe('GET /api/me 0');
  await wait(200);
  expect(asked).toHaveLength(1);
});
