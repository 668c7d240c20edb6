// What is typed and not saved: asked for before leaving, offered on coming back, gone after saving and signing out.
import { MantineProvider, Modal } from '@mantine/core';
import { QueryClient, QueryClientProvider, QueryObserver } from '@tanstack/react-query';
import { act, fireEvent, render, screen, waitFor } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { createMemoryRouter, RouterProvider } from 'react-router';
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { api, byHand, setCsrfToken } from '../../../src/api/client';
import { address, key, ofSession } from '../../../src/api/address';
import { forgetEverything } from '../../../src/api/queries';
import type { Patient } from '../../../src/api/types';
import { PatientForm } from '../../../src/components/forms/PatientForm';
import { Shell } from '../../../src/components/Shell';
import { pruneDrafts, readDraft, writeDraft } from '../../../src/lib/editing/drafts';
import { hasUnsaved, releaseAll } from '../../../src/lib/editing/unsaved';
import { PatientNewPage } from '../../../src/pages/PatientNew';
import { renderPage, THERAPIST } from '../render';

beforeEach(() => {
  sessionStorage.clear();
  localStorage.clear();
});
afterEach(() => {
  releaseAll();
  vi.unstubAllGlobals();
});

const drafts = () => Object.keys(sessionStorage).filter((key) => key.startsWith('telemotion.draft.'));
const open = () =>
  renderPage(<PatientNewPage />, {
    at: '/patients/new',
    path: '/patients/new',
    answers: { 'POST /api/patients': [201, { id: 'p' }] },
  });
const type = (label: string, value: string) =>
  fireEvent.change(screen.getByRole('textbox', { name: label }), { target: { value } });

it('asks before leaving, and offers what was typed on coming back', async () => {
  const view = open();
  type('Family name', 'Berg');
  type('Notes', 'left shoulder');
  await act(() => view.router.navigate('/'));
  await userEvent.click(await screen.findByRole('button', { name: 'Stay here' }));
  expect(screen.getByRole<HTMLInputElement>('textbox', { name: 'Family name' }).value).toBe('Berg');
  await act(() => view.router.navigate('/elsewhere'));
  await userEvent.click(await screen.findByRole('button', { name: 'Leave, go on later' }));
  expect(await screen.findByText('elsewhere')).toBeTruthy();
  expect(drafts()).toHaveLength(1);

  await act(() => view.router.navigate('/patients/new'));
  expect(screen.getByRole<HTMLInputElement>('textbox', { name: 'Family name' }).value).toBe('');
  expect(screen.getByText(/^You began to change this and did not save it/)).toBeTruthy();
  await userEvent.click(screen.getByRole('button', { name: 'Continue with it' }));
  expect(screen.getByRole<HTMLInputElement>('textbox', { name: 'Family name' }).value).toBe('Berg');
  expect(screen.getByRole<HTMLInputElement>('textbox', { name: 'Notes' }).value).toBe('left shoulder');
  expect(screen.getByRole<HTMLInputElement>('checkbox').checked, 'a consent is said anew').toBe(false);
  await userEvent.click(screen.getByRole('button', { name: 'Save' }));
  // Saved: nobody is asked, and nothing stays.
  expect(await screen.findByText('elsewhere')).toBeTruthy();
  await new Promise((written) => setTimeout(written, 400));
  expect(drafts(), 'nor is it written afterwards').toEqual([]);
});

it('keeps nothing of what is discarded or undone by hand', async () => {
  const view = open();
  type('Family name', 'Berg');
  await waitFor(() => expect(drafts()).toHaveLength(1));
  type('Family name', '');
  await waitFor(() => expect(drafts()).toEqual([]));
  expect(hasUnsaved()).toBe(false);
  await act(() => view.router.navigate('/elsewhere'));
  expect(screen.getByText('elsewhere')).toBeTruthy();

  await act(() => view.router.navigate('/patients/new'));
  type('Family name', 'Berg');
  await act(() => view.router.navigate('/elsewhere'));
  await userEvent.click(await screen.findByRole('button', { name: 'Discard and leave' }));
  expect(await screen.findByText('elsewhere')).toBeTruthy();
  expect(drafts()).toEqual([]);
});

it('neither overwrites nor removes a draft while it is offered and nobody has decided', async () => {
  const earlier = { texts: { family: 'Berg' }, start: { family: '' } };
  const stored = () => readDraft(THERAPIST.account_id, 'patient:new')?.value;
  writeDraft(THERAPIST.account_id, 'patient:new', earlier);
  const view = open();
  type('Family name', 'Lind');
  await new Promise((written) => setTimeout(written, 400));
  expect(stored(), 'one letter does not replace it').toEqual(earlier);
  await act(() => view.router.navigate('/elsewhere'));
  expect(await screen.findByText(/An earlier draft is still offered/)).toBeTruthy();
  expect(screen.queryByRole('button', { name: 'Leave, go on later' })).toBeNull();
  await userEvent.click(screen.getByRole('button', { name: 'Stay here' }));
  type('Family name', '');
  expect(stored()).toEqual(earlier);
  await userEvent.click(screen.getByRole('button', { name: 'Cancel' }));
  expect(stored(), 'nor does Cancel remove it').toEqual(earlier);

  await act(() => view.router.navigate('/patients/new'));
  type('Family name', 'Lind');
  await userEvent.click(screen.getByRole('button', { name: 'Discard it' }));
  await waitFor(() => expect(stored()).toMatchObject({ texts: { family: 'Lind' } }));
  await userEvent.click(screen.getByRole('button', { name: 'Cancel' }));
  expect(stored(), 'its own it does remove').toBeUndefined();
});

it('counts as saved as soon as the service has stored it, however long the lists behind it take', async () => {
  const view = open();
  const plain = fetch;
  let isStored = false;
  vi.stubGlobal('fetch', (path: string, init?: RequestInit) => {
    if (init?.method === 'POST') isStored = true;
    return init?.method ? plain(path, init) : new Promise(() => undefined);
  });
  // The list that a new patient makes old, and that nobody answers.
  const list = new QueryObserver(view.client, { queryKey: key('caseload'), queryFn: () => fetch('/api/caseload') });
  const stop = list.subscribe(() => undefined);
  type('Family name', 'Berg');
  await userEvent.click(screen.getByRole('button', { name: 'Save' }));
  await waitFor(() => expect(isStored).toBe(true));
  await waitFor(() => expect(hasUnsaved()).toBe(false));
  await act(() => view.router.navigate('/elsewhere'));
  expect(screen.getByText('elsewhere')).toBeTruthy();
  expect(drafts()).toEqual([]);
  stop();
});

const PATIENT = {
  id: 'p',
  given_name: 'Ada',
  family_name: 'Berg',
  birth_date: null,
  affected_side: 'left',
  notes: 'by a colleague',
  body_dimensions: { stature_m: 1.7, hand_m: 0.18 },
} as unknown as Patient;

it('changes only what was typed, over what a colleague saved meanwhile', async () => {
  const start = { given: 'Ada', family: 'Berk', birth: '', side: 'right', notes: '' };
  const lengths = { stature_m: '', upper_arm_m: '', forearm_m: '', hand_m: '', shoulder_width_m: '', trunk_m: '' };
  writeDraft(THERAPIST.account_id, 'patient:p', {
    start: { ...start, lengths },
    texts: { ...start, family: 'Bergh', lengths: { ...lengths, trunk_m: '50' } },
  });
  const saved = vi.fn();
  const view = renderPage(<PatientForm patient={PATIENT} onSaved={saved} onCancel={() => undefined} />, {
    answers: { 'PATCH /api/patients/p': PATIENT },
  });
  await userEvent.click(screen.getByRole('button', { name: 'Continue with it' }));
  expect(screen.getByRole<HTMLInputElement>('textbox', { name: 'Notes' }).value).toBe('by a colleague');
  await userEvent.click(screen.getByRole('button', { name: 'Save' }));
  await waitFor(() => expect(saved).toHaveBeenCalled());
  expect(view.asked.find((one) => one.method === 'PATCH')?.body).toEqual({
    family_name: 'Bergh',
    body_dimensions: {
      stature_m: 1.7,
      hand_m: 0.18,
      trunk_m: 0.5,
      upper_arm_m: null,
      forearm_m: null,
      shoulder_width_m: null,
    },
  });
});

it('asks before the tab is closed only while something is not saved', () => {
  open();
  const closing = () => {
    const event = new Event('beforeunload', { cancelable: true });
    window.dispatchEvent(event);
    return event.defaultPrevented;
  };
  expect(closing()).toBe(false);
  type('Family name', 'Berg');
  expect(closing()).toBe(true);
});

it('leaves nothing on the device after a sign-out, in a tab that is opened again either', () => {
  open();
  type('Family name', 'Berg');
  window.dispatchEvent(new Event('pagehide'));
  expect(drafts()).toHaveLength(1);
  const stored = { ...sessionStorage } as Record<string, string>;
  forgetEverything(new QueryClient());
  expect(drafts()).toEqual([]);
  window.dispatchEvent(new Event('pagehide'));
  expect(drafts(), 'nor is it written again').toEqual([]);
  // A browser that opens a closed tab again brings its storage back.
  for (const [key, value] of Object.entries(stored)) sessionStorage.setItem(key, value);
  expect(readDraft(THERAPIST.account_id, 'patient:new')).toBeNull();
  pruneDrafts();
  expect(drafts()).toEqual([]);
});

it('shows nobody the draft of another account', () => {
  writeDraft('another', 'patient:new', { family: 'Berg' });
  open();
  expect(screen.queryByText(/^You began to change this/)).toBeNull();
});

const NOBODY = { given_name: '', family_name: '' };
const refusedOf = (asking: Promise<unknown>) =>
  asking.then(
    () => 'answered',
    (error: { status: number }) => error.status,
  );

const ENDED = { code: 'sign_in_required', message: 'Sign in again to continue.', details: {} };

/** The whole frame around a form; `answer` says what the service answers. */
function framed(answer: (what: string, path: string, token: string) => Response) {
  const startAnew = vi.fn();
  const asked: string[] = [];
  vi.stubGlobal('fetch', (path: string, init: RequestInit = {}) => {
    const what = `${init.method ?? 'GET'} ${path}`;
    const token = new Headers(init.headers).get('X-CSRF-Token') ?? '';
    asked.push(`${what} ${token}`.trim());
    return Promise.resolve(answer(what, path, token));
  });
  const frozen = { addEventListener: () => undefined, removeEventListener: () => undefined };
  vi.stubGlobal('matchMedia', () => ({
    matches: false,
    ...frozen,
    addListener: () => undefined,
    removeListener: () => undefined,
  }));
  vi.spyOn(window, 'scrollTo').mockImplementation(() => undefined);
  const client = new QueryClient({ defaultOptions: { queries: { retry: false } } });
  client.setQueryData(key('me'), THERAPIST);
  setCsrfToken('first', THERAPIST.account_id);
  const router = createMemoryRouter(
    [
      {
        path: '/',
        element: <Shell startAnew={startAnew} />,
        children: [
          { path: 'patients/new', element: <PatientNewPage /> },
          { path: '*', element: <p>elsewhere</p> },
        ],
      },
      { path: '/sign-in', element: <p>the page of the sign-in</p> },
    ],
    { initialEntries: ['/patients/new'] },
  );
  const view = render(
    <MantineProvider env="test">
      <QueryClientProvider client={client}>
        <RouterProvider router={router} />
      </QueryClientProvider>
    </MantineProvider>,
  );
  type('Family name', 'Berg');
  return { asked, client, router, startAnew, view };
}

/** The frame around a form whose sign-in has ended; `account` signs in over it. */
async function endedOver(account: string) {
  let isEnded = true;
  const now = { ...THERAPIST, account_id: account, csrf_token: 'second' };
  const frame = framed((what, path) => {
    if (what === 'POST /api/sign-in') isEnded = false;
    if (isEnded) return Response.json(ENDED, { status: 401 });
    return /sign-in$|me$/.test(path) ? Response.json(now) : Response.json({ id: 'p' }, { status: 201 });
  });
  fireEvent.click(screen.getByRole('button', { name: 'Save' }));
  const dialog = await screen.findByRole('dialog', { name: 'Sign in again' });
  expect(screen.getByRole<HTMLInputElement>('textbox', { name: 'Family name', hidden: true }).value).toBe('Berg');
  return { ...frame, dialog };
}

it('signs in over a form, which stays, and goes on with the save', async () => {
  const { asked, router } = await endedOver(THERAPIST.account_id);
  fireEvent.change(screen.getByLabelText('Password'), { target: { value: 'mine' } });
  await userEvent.click(screen.getByRole('button', { name: 'Sign in and continue' }));
  await waitFor(() => expect(router.state.location.pathname).toBe('/patients/p'));
  expect(asked.filter((one) => one.startsWith('POST'))).toEqual([
    'POST /api/patients first',
    'POST /api/sign-in first',
    'POST /api/patients second',
  ]);
});

it('saves nothing in the name of another account, which gets neither form nor draft', async () => {
  const { asked, startAnew } = await endedOver('another');
  const waiting = refusedOf(byHand.delete('/api/grants/{grant_id}', { path: { grant_id: 'g' } }));
  fireEvent.change(screen.getByLabelText('Password'), { target: { value: 'hers' } });
  await userEvent.click(screen.getByRole('button', { name: 'Sign in and continue' }));
  await waitFor(() => expect(startAnew).toHaveBeenCalled());
  expect(hasUnsaved()).toBe(false);
  expect(await waiting).toBe(401);
  expect(screen.queryByRole('textbox', { hidden: true }), 'the page is blank until it is loaded anew').toBeNull();
  expect(screen.queryByText(THERAPIST.display_name)).toBeNull();
  await new Promise((done) => setTimeout(done, 50));
  expect(asked.filter((one) => one.startsWith('POST /api/patients'))).toEqual(['POST /api/patients first']);
  window.dispatchEvent(new Event('pagehide'));
  expect(drafts()).toEqual([]);
});

it('leads to the page of the sign-in when somebody leaves the form there', async () => {
  const { router } = await endedOver(THERAPIST.account_id);
  await userEvent.click(screen.getByRole('button', { name: 'Leave the page' }));
  await waitFor(() => expect(router.state.location.pathname).toBe('/sign-in'));
});

it('refuses what waits for a sign-in when the frame goes or nobody is signed in, and asks again the next time', async () => {
  const first = await endedOver(THERAPIST.account_id);
  const waiting = refusedOf(api.get(address('/api/caseload')));
  act(() => void first.client.setQueryData(key('me'), null));
  expect(await waiting).toBe(401);
  await waitFor(() => expect(first.router.state.location.pathname).toBe('/sign-in'));
  expect(await refusedOf(api.get(address('/api/caseload')))).toBe(401);
  first.view.unmount();

  const second = await endedOver(THERAPIST.account_id);
  const other = refusedOf(api.get(address('/api/caseload')));
  second.view.unmount();
  expect(await other).toBe(401);
  expect(await refusedOf(api.get(address('/api/caseload')))).toBe(401);
});

it('leaves the question open when the page asks for something by itself, though nothing is unsaved any more', async () => {
  await endedOver(THERAPIST.account_id);
  act(() => releaseAll());
  const poll = api.get(address('/api/caseload'));
  let isSettled = false;
  poll.finally(() => (isSettled = true)).catch(() => undefined);
  await new Promise((done) => setTimeout(done, 30));
  expect(isSettled, 'it waits as well').toBe(false);
  fireEvent.change(screen.getByLabelText('Password'), { target: { value: 'mine' } });
  await userEvent.click(screen.getByRole('button', { name: 'Sign in and continue' }));
  expect(await poll).toBeTruthy();
});

it('asks for the sign-in over a page only for what a person pressed', async () => {
  framed(() => Response.json(ENDED, { status: 401 }));
  act(() => releaseAll());
  expect(await refusedOf(api.post('/api/sessions/{session_id}/close', ofSession('s')))).toBe(401);
  expect(screen.queryByRole('dialog')).toBeNull();
  void refusedOf(byHand.post('/api/sessions/{session_id}/stop', ofSession('s')));
  expect(await screen.findByRole('dialog', { name: 'Sign in again' })).toBeTruthy();
});

it('leaves a form open that is a dialog itself, when Escape is pressed in the question over it', async () => {
  const close = vi.fn();
  framed(() => Response.json(ENDED, { status: 401 }));
  const form = (title: string) => (
    <MantineProvider env="test">
      <Modal opened onClose={close} title={title}>
        words
      </Modal>
    </MantineProvider>
  );
  const below = render(form('Below'));
  void refusedOf(byHand.post('/api/patients', { body: NOBODY }));
  const password = await screen.findByLabelText('Password');
  below.rerender(form('Below, drawn again'));
  fireEvent.keyDown(password, { key: 'Escape' });
  expect(close).not.toHaveBeenCalled();
  await userEvent.click(screen.getByRole('button', { name: 'Leave the page' }));
  await screen.findByText('the page of the sign-in');
  fireEvent.keyDown(document.body, { key: 'Escape' });
  expect(close).toHaveBeenCalledOnce();
});

const OLD_TOKEN = { code: 'not_allowed', message: 'read it again', details: { header: 'X-CSRF-Token' } };

/** Save while another tab has signed in as `account`. */
function signedInElsewhere(account: string) {
  const frame = framed((_, path, token) => {
    if (path === '/api/me') return Response.json({ ...THERAPIST, account_id: account, csrf_token: 'second' });
    return token === 'second' ? Response.json({ id: 'p' }, { status: 201 }) : Response.json(OLD_TOKEN, { status: 403 });
  });
  fireEvent.click(screen.getByRole('button', { name: 'Save' }));
  return frame;
}

it('saves with the token of the sign-in that the same account made in another tab', async () => {
  const { asked, router } = signedInElsewhere(THERAPIST.account_id);
  await waitFor(() => expect(router.state.location.pathname).toBe('/patients/p'));
  expect(asked.filter((one) => one.startsWith('POST'))).toEqual([
    'POST /api/patients first',
    'POST /api/patients second',
  ]);
});

it('sends a change once more only, and leaves the page to another account of another tab', async () => {
  const { asked, startAnew, view } = signedInElsewhere('another');
  await waitFor(() => expect(startAnew).toHaveBeenCalled());
  expect(screen.queryByRole('textbox', { hidden: true })).toBeNull();
  expect(drafts()).toEqual([]);
  expect(asked.filter((one) => one.startsWith('POST'))).toEqual(['POST /api/patients first']);
  view.unmount();

  const refused = framed((_, path) =>
    path === '/api/me' ? Response.json(THERAPIST) : Response.json(OLD_TOKEN, { status: 403 }),
  );
  expect(await refusedOf(byHand.post('/api/patients', { body: NOBODY }))).toBe(403);
  expect(refused.asked.filter((one) => one.startsWith('POST'))).toHaveLength(2);
});
