import { MantineProvider } from '@mantine/core';
import { QueryClient, QueryClientProvider } from '@tanstack/react-query';
import { render } from '@testing-library/react';
import type { ReactElement } from 'react';
import { createMemoryRouter, Outlet, RouterProvider } from 'react-router';
import { vi } from 'vitest';
import type { Me } from '../../src/api/types';

export const THERAPIST: Me = {
  account_id: 'a',
  display_name: 'Ingrid Solberg',
  email: 'i@example.org',
  role: 'therapist',
  clinic_id: 'c',
  clinic_name: 'Clinic',
  patient_id: null,
  locale: 'en',
  csrf_token: 'token',
  store_key: 'A'.repeat(43) + '=',
  idle_minutes: 60,
};

/** Answer of the service for a path, with its status where it is not 200. */
export type Answers = Record<string, unknown | [number, unknown]>;

/** A page of a list that another follows, as the answer for its path. */
export class Paged {
  constructor(
    readonly rows: unknown[],
    readonly next: string,
  ) {}
}

/** Render a page at a path inside the shell's context, against answers instead of a service. */
export function renderPage(element: ReactElement, options: { at?: string; path?: string; answers: Answers; me?: Me }) {
  const { at = '/', path = '/', answers, me = THERAPIST } = options;
  const asked: { method: string; path: string; body: unknown; headers: Headers }[] = [];
  vi.stubGlobal('fetch', (input: string, init: RequestInit = {}) => {
    const method = init.method ?? 'GET';
    asked.push({
      method,
      path: input,
      body: init.body ? JSON.parse(String(init.body)) : undefined,
      headers: new Headers(init.headers),
    });
    const found = answers[method === 'GET' ? input : `${method} ${input}`];
    if (found instanceof Paged)
      return Promise.resolve(Response.json(found.rows, { headers: { Link: `<${found.next}>; rel="next"` } }));
    const [status, body] =
      Array.isArray(found) && typeof found[0] === 'number'
        ? (found as [number, unknown])
        : [found === undefined ? 404 : 200, found];
    return Promise.resolve(
      Response.json(body ?? { code: 'not_found', message: `nothing at ${input}`, details: {} }, { status }),
    );
  });
  vi.stubGlobal('matchMedia', () => ({
    matches: false,
    addEventListener: () => undefined,
    removeEventListener: () => undefined,
    addListener: () => undefined,
    removeListener: () => undefined,
  }));
  const router = createMemoryRouter(
    [
      {
        path: '/',
        element: <Outlet context={me} />,
        children: [
          { path: path === '/' ? '' : path.slice(1), index: path === '/' ? true : undefined, element } as never,
          { path: '*', element: <p>elsewhere</p> },
        ],
      },
    ],
    { initialEntries: [at] },
  );
  const client = new QueryClient({ defaultOptions: { queries: { retry: false } } });
  const view = render(
    <MantineProvider env="test">
      <QueryClientProvider client={client}>
        <RouterProvider router={router} />
      </QueryClientProvider>
    </MantineProvider>,
  );
  return { ...view, asked, client, router };
}
