// Walks through every page that a patient can open, by every address there is, and reads every word on it.
import { MantineProvider } from '@mantine/core';
import { QueryClient, QueryClientProvider } from '@tanstack/react-query';
import { act, render, screen, waitFor } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { createMemoryRouter, RouterProvider, type RouteObject } from 'react-router';
import { afterEach, describe, expect, it, vi } from 'vitest';
import { routes } from '../../../src/App';
import { ownPage } from '../../../src/components/ByRole';
import type { Exercise, LiveMessage, SessionDetail, SessionState } from '../../../src/api/types';
import { analystWordsIn } from '../analystWords';
import { answers, guidance, guide, health, layoutMessage, stateMessage } from '../patientData';

// Each page is a piece of the program that is compiled when it is first opened.
vi.setConfig({ testTimeout: 20_000 });

afterEach(() => {
  vi.unstubAllGlobals();
  vi.restoreAllMocks();
});

class FakeSocket {
  static readonly OPEN = 1;
  static all: FakeSocket[] = [];
  readyState = 1;
  isOpened = false;
  binaryType = '';
  onopen: (() => void) | null = null;
  onmessage: ((event: { data: string }) => void) | null = null;
  onclose: ((event: { code: number; reason: string }) => void) | null = null;
  constructor(readonly url: string) {
    FakeSocket.all.push(this);
  }
  send() {}
  close() {}
}

/** Say something over the live socket of the page. */
function say(...messages: LiveMessage[]) {
  const socket = FakeSocket.all.findLast((one) => one.url.includes('/ws/live/'));
  act(() => {
    if (socket && !socket.isOpened) socket.onopen?.();
    if (socket) socket.isOpened = true;
    for (const message of messages) socket?.onmessage?.({ data: JSON.stringify(message) });
  });
  return socket;
}

function open(
  at: string,
  change: Partial<SessionDetail> = {},
  ofExercise: Partial<Exercise> = {},
  onCreate: (body: unknown) => void = () => undefined,
) {
  const given = answers(change, ofExercise);
  const asked: string[] = [];
  FakeSocket.all = [];
  vi.stubGlobal('WebSocket', FakeSocket);
  vi.stubGlobal('scrollTo', () => undefined);
  vi.stubGlobal('fetch', (path: string, init: RequestInit = {}) => {
    const method = init.method ?? 'GET';
    asked.push(`${method} ${path}`);
    if (method === 'POST' && path === '/api/sessions') onCreate(JSON.parse(String(init.body)));
    const found = given[method === 'GET' ? path : `${method} ${path}`];
    const [status, body] =
      Array.isArray(found) && typeof found[0] === 'number'
        ? (found as [number, unknown])
        : [found === undefined ? 404 : 200, found];
    return Promise.resolve(
      Response.json(body ?? { code: 'not_found', message: `The estimator knows nothing at ${path}.`, details: {} }, {
        status,
      }),
    );
  });
  const router = createMemoryRouter(routes, { initialEntries: [at] });
  const client = new QueryClient({ defaultOptions: { queries: { retry: false } } });
  const view = render(
    <MantineProvider env="test">
      <QueryClientProvider client={client}>
        <RouterProvider router={router} />
      </QueryClientProvider>
    </MantineProvider>,
  );
  return { ...view, router, asked };
}

/** Wait until nothing on the page is being fetched, then return the analyst's words on it. */
async function read(): Promise<string[]> {
  await screen.findByRole('heading', { level: 1 });
  await waitFor(() => expect(screen.queryAllByText('Loading')).toEqual([]));
  return analystWordsIn(document.body);
}

function paths(of: readonly RouteObject[], base = ''): string[] {
  return of.flatMap((route) => {
    const here = route.path?.startsWith('/')
      ? route.path
      : [base.replace(/\/$/, ''), route.path].filter((part) => part !== undefined).join('/');
    return [...(route.path !== undefined || route.index ? [here || '/'] : []), ...paths(route.children ?? [], here)];
  });
}
const filled = (path: string) =>
  path.replace(':sessionId', 's').replace(':patientId', 'p').replace(':exerciseId', 'e').replace('*', 'nowhere');
const ALL = [...new Set(paths(routes))].map(filled).filter((path) => path !== '/sign-in');

describe('a patient', () => {
  it.each(ALL)('reads no analyst’s word at %s', async (path) => {
    const { router } = open(path);
    expect(await read()).toEqual([]);
    expect(router.state.location.pathname).toMatch(/^\/$|^\/my\/|^\/account$|^\/nowhere$/);
  });

  it('is taken from the workstation to the own page of the same session', () => {
    expect(ALL).toContain('/sessions/s/live');
    expect(ownPage('/sessions/s/live')).toBe('/my/sessions/s/live');
    expect(ownPage('/sessions/s')).toBe('/my/sessions/s');
    expect(ownPage('/sessions/s/estimators')).toBe('/my/sessions/s');
    expect(ownPage('/patients/p')).toBe('/');
  });

  it.each<[SessionState, string, LiveMessage[]]>([
    ['created', 'Put on the sensors', []],
    ['calibrating', 'Stand still', [stateMessage('calibrating', { calibration: null })]],
    ['calibrating', 'Hold still', [stateMessage('calibrating', { calibration: null }), guide('collecting')]],
    ['calibrating', 'Once more, please', [stateMessage('calibrating', { calibration: null }), guide('redo')]],
    ['ready', 'Ready', [stateMessage('ready')]],
    ['recording', 'Go!', [stateMessage('recording', { recording_start_s: 4 })]],
    ['link_lost', 'No signal from the sensors', [stateMessage('link_lost', { recording_start_s: 4 })]],
    ['closing', 'Well done', [stateMessage('closing')]],
    ['failed', 'Something went wrong', [stateMessage('failed')]],
  ])('reads in plain words that the session is %s: %s', async (state, words, messages) => {
    const complaints = vi.spyOn(console, 'error').mockImplementation(() => undefined);
    open('/my/sessions/s/live', { state, recording_start_s: null, recording_end_s: null });
    await screen.findByRole('heading', { level: 1 });
    await waitFor(() => expect(FakeSocket.all.length).toBeGreaterThan(0));
    say(...messages, health, ...(state === 'created' ? [] : [layoutMessage]));
    expect(await screen.findByRole('heading', { name: words })).toBeTruthy();
    expect(await read()).toEqual([]);
    // React says here when elements are nested as no browser reads them.
    expect(
      complaints.mock.calls.map((said) => said.join(' ')).filter((said) => said.includes('cannot be a descendant')),
    ).toEqual([]);
  });

  it('reads what a walk asks for, and starts it with sensors on the feet', async () => {
    const sent: unknown[] = [];
    open(
      '/',
      {},
      { movement: 'timed_up_and_go', description: 'Stand up, walk to the mark and back, sit down.' },
      (body) => sent.push(body),
    );
    await screen.findByText('Stand up, walk to the mark and back, sit down.');
    expect(screen.getByText(/^One walk,/)).toBeTruthy();
    expect(screen.queryByText(/10 times|rounds/)).toBeNull();
    await userEvent.click(await screen.findByRole('button', { name: 'Start: Reach forward' }));
    expect(sent).toMatchObject([{ pipeline: 'gait', placements: ['foot_left', 'foot_right'], prescription_id: 'pr' }]);
  });

  it('starts and ends a recording with one button each, and reads a refusal in plain words', async () => {
    const { asked } = open('/my/sessions/s/live', { state: 'ready', recording_start_s: null, recording_end_s: null });
    await waitFor(() => expect(FakeSocket.all.length).toBeGreaterThan(0));
    say(stateMessage('ready'));
    await userEvent.click(await screen.findByRole('button', { name: 'Go' }));
    expect(asked).toContain('POST /api/sessions/s/record');
    expect(
      (await screen.findByText('This exercise was not found. Go back to the first page.')).closest('[role=alert]'),
    ).toBeTruthy();
    expect(await read()).toEqual([]);
    say(stateMessage('recording', { recording_start_s: 3 }));
    await userEvent.click(await screen.findByRole('button', { name: 'I have finished' }));
    expect(asked).toContain('POST /api/sessions/s/stop');
  });

  it('reads whether the movement is being stored', async () => {
    open('/my/sessions/s/live', { state: 'recording', recording_end_s: null });
    await waitFor(() => expect(FakeSocket.all.length).toBeGreaterThan(0));
    say(stateMessage('recording', { recording_start_s: 3 }), health);
    expect(await screen.findByText('Your movement is being stored.')).toBeTruthy();
    say({ ...health, is_being_stored: false });
    expect((await screen.findByText('Not being stored')).closest('[role=alert]')).toBeTruthy();
    expect(screen.queryByText('Your movement is being stored.')).toBeNull();
    expect(await read()).toEqual([]);
  });

  it('rests without a signal in peace, and reads large that it is missing once she goes on', async () => {
    open('/my/sessions/s/live', { state: 'recording', recording_end_s: null });
    await waitFor(() => expect(FakeSocket.all.length).toBeGreaterThan(0));
    const silent = stateMessage('link_lost', { recording_start_s: 3 });
    say(silent, guidance({ status: 'paused', cause: 'person' }));
    expect(await screen.findByRole('heading', { name: 'Take a break' })).toBeTruthy();
    expect(screen.getByText(/^No signal from the sensors at the moment/).closest('[role]')).toBeNull();
    expect(screen.queryByRole('heading', { name: 'No signal from the sensors' })).toBeNull();
    expect(screen.queryByRole('heading', { name: 'Did this device measure?' })).toBeNull();
    expect(await read()).toEqual([]);
    // What only lasts until the sensors are seen again is no rest.
    say(guidance({ status: 'paused', cause: 'lost' }));
    expect(screen.getByRole('heading', { name: 'No signal from the sensors' })).toBeTruthy();
    say(guidance({ status: 'waiting' }));
    expect(screen.getByRole('heading', { name: 'No signal from the sensors' })).toBeTruthy();
    expect(screen.queryByText(/at the moment. It only matters/)).toBeNull();
    expect(screen.getByRole('heading', { name: 'Did this device measure?' })).toBeTruthy();
  });

  it('reads quietly that a sensor is lost while she rests, and as an alert when she goes on', async () => {
    open('/my/sessions/s/live', { state: 'recording', recording_end_s: null });
    await waitFor(() => expect(FakeSocket.all.length).toBeGreaterThan(0));
    const lost = { ...health, sensors: health.sensors.map((one) => ({ ...one, status: 'lost' as const })) };
    say(stateMessage('recording', { recording_start_s: 3 }), lost, guidance({ status: 'paused', cause: 'set' }));
    expect((await screen.findByText(/^No signal from:/)).closest('[role=alert]')).toBeNull();
    say(guidance({ status: 'waiting' }));
    expect(screen.getByText(/^No signal from:/).closest('[role=alert]')).toBeTruthy();
  });

  it('reads one thing where another window measures, and the steps once that is closed', async () => {
    const held = [{ name: 'telemotion.measuring' }];
    vi.stubGlobal('navigator', {
      ...navigator,
      locks: { query: () => Promise.resolve({ held }), request: () => Promise.resolve() },
    });
    open('/my/sessions/s/live', { state: 'created', recording_start_s: null, recording_end_s: null });
    expect(await screen.findByRole('heading', { name: 'You are measuring in another window' })).toBeTruthy();
    expect(screen.queryByRole('heading', { name: 'Put on the sensors' })).toBeNull();
    expect(screen.queryByRole('button', { name: /Bluetooth sensors/ })).toBeNull();
    expect(await read()).toEqual([]);
    held.pop();
    expect(await screen.findByRole('heading', { name: 'Put on the sensors' }, { timeout: 5000 })).toBeTruthy();
    expect(await screen.findByRole('button', { name: /Bluetooth sensors/ })).toBeTruthy();
  });

  it('reads that nothing is known while the service is out of reach', async () => {
    open('/my/sessions/s/live', { state: 'recording', recording_end_s: null });
    await waitFor(() => expect(FakeSocket.all.length).toBeGreaterThan(0));
    const socket = say(stateMessage('recording', { recording_start_s: 3 }));
    act(() => socket?.onclose?.({ code: 1006, reason: '' }));
    expect(await screen.findByRole('heading', { name: 'No connection' })).toBeTruthy();
    expect(screen.getByText(/does not know whether your exercise is being stored/)).toBeTruthy();
    expect(screen.queryByText('Your movement is being stored.')).toBeNull();
  });

  it('sees results by the day, in sentences, and opens the own replay', async () => {
    open('/my/results');
    expect((await screen.findAllByRole('heading', { level: 3 })).map((one) => one.textContent)).toEqual([
      'Friday 20 November',
      'Wednesday 18 November',
    ]);
    const links = await screen.findAllByRole('link', { name: /Reach|times|minute/ });
    expect(links.map((one) => one.getAttribute('href'))).toEqual([
      '/my/sessions/o',
      '/my/sessions/s',
      '/my/sessions/n',
    ]);
    await screen.findByText(/10 times, 4 minutes/);
    expect(screen.getByText(/8° more than/)).toBeTruthy();
  });

  it('reads one true sentence beside the replay', async () => {
    open('/my/sessions/s');
    expect(
      await screen.findByText(
        'You did it 10 times. Your elbow moved 59° on average. In your therapist’s example it moved 66°.',
      ),
    ).toBeTruthy();
    expect(screen.getByRole('button', { name: 'Play' })).toBeTruthy();
  });
});
