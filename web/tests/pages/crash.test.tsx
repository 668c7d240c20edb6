import { MantineProvider } from '@mantine/core';
import { act, render, screen, waitFor } from '@testing-library/react';
import { createMemoryRouter, RouterProvider } from 'react-router';
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { CrashPage } from '../../src/pages/Crash';

const MISSING = new TypeError(
  'Failed to fetch dynamically imported module: http://127.0.0.1/assets/SessionPage-1a2b.js',
);
let answer: () => Promise<Response>;

beforeEach(() => {
  vi.stubGlobal('fetch', () => answer());
  vi.stubGlobal('matchMedia', () => ({
    matches: false,
    addEventListener: () => undefined,
    removeEventListener: () => undefined,
  }));
  vi.spyOn(console, 'error').mockImplementation(() => undefined);
});
afterEach(() => vi.unstubAllGlobals());

function open(fault: Error): ReturnType<typeof vi.fn> {
  const onReload = vi.fn();
  const router = createMemoryRouter([
    {
      path: '/',
      lazy: () => Promise.reject(fault),
      errorElement: <CrashPage onReload={onReload} />,
      HydrateFallback: () => null,
    },
  ]);
  render(
    <MantineProvider env="test">
      <RouterProvider router={router} />
    </MantineProvider>,
  );
  return onReload;
}

it('does not blame the page when the network is away, and goes on by itself when it is back', async () => {
  answer = () => Promise.reject(new TypeError('Failed to fetch'));
  const onReload = open(MISSING);
  expect(await screen.findByRole('heading', { name: 'No connection to the service' })).toBeTruthy();
  expect(screen.queryByText(/fault/)).toBeNull();
  expect(onReload).not.toHaveBeenCalled();
  answer = () => Promise.resolve(Response.json({ status: 'ok' }));
  // The browser may say so before the page listens: on a busy machine its effect comes after its picture.
  await waitFor(() => {
    act(() => void window.dispatchEvent(new Event('online')));
    expect(onReload).toHaveBeenCalled();
  });
});

it('knows a piece that a newer service no longer has', async () => {
  answer = () => Promise.resolve(Response.json({ status: 'ok' }));
  const onReload = open(MISSING);
  expect(await screen.findByRole('heading', { name: 'There is a newer version of this page' })).toBeTruthy();
  expect(onReload).not.toHaveBeenCalled();
});

it('owns up to a fault of its own', async () => {
  answer = () => Promise.resolve(Response.json({ status: 'ok' }));
  open(new TypeError("Cannot read properties of undefined (reading 'x')"));
  expect(await screen.findByRole('heading', { name: 'This page stopped working' })).toBeTruthy();
});
