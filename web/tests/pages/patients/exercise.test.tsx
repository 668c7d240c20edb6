// The page of an exercise while it is done: one line, the count, and buttons that hold at once whatever the network does.
import { MantineProvider } from '@mantine/core';
import { QueryClient, QueryClientProvider } from '@tanstack/react-query';
import { render, screen, waitFor } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import axe from 'axe-core';
import { afterEach, describe, expect, it, vi } from 'vitest';
import type { GuidanceMessage, SessionDetail } from '../../../src/api/types';
import After from '../../../src/pages/mine/exercise/After';
import { Controls, Count, NowLine } from '../../../src/pages/mine/exercise/Doing';
import { momentOf } from '../../../src/pages/mine/moment';
import { heldBy, useHold } from '../../../src/pages/mine/exercise/useHold';
import { analystWordsIn } from '../analystWords';
import { guidance as said } from '../patientData';

afterEach(() => {
  vi.unstubAllGlobals();
  localStorage.clear();
});

let asked: [string, unknown][] = [];
let onFinish = vi.fn();

function Exercise({ guidance }: { guidance: GuidanceMessage }) {
  const hold = useHold('s', guidance);
  return (
    <main>
      <h1>Reach forward</h1>
      <NowLine guidance={guidance} hold={hold} posture="standing" onFinish={onFinish} isEnding={false} />
      <Count guidance={guidance} />
      <Controls guidance={guidance} hold={hold} />
    </main>
  );
}

function show(node: React.ReactNode, answer: (path: string, body: unknown) => Response | Promise<Response>) {
  asked = [];
  onFinish = vi.fn();
  vi.stubGlobal('fetch', (path: string, init: RequestInit = {}) => {
    const body: unknown = init.body ? JSON.parse(String(init.body)) : null;
    asked.push([`${init.method ?? 'GET'} ${path}`, body]);
    return Promise.resolve(answer(path, body));
  });
  const client = new QueryClient({ defaultOptions: { queries: { retry: false } } });
  const all = (inner: React.ReactNode) => (
    <MantineProvider env="test">
      <QueryClientProvider client={client}>{inner}</QueryClientProvider>
    </MantineProvider>
  );
  const view = render(all(node));
  return { ...view, again: (inner: React.ReactNode) => view.rerender(all(inner)) };
}

async function faults(of: Element) {
  const found = await axe.run(of, { rules: { 'color-contrast': { enabled: false } } });
  return found.violations.map((one) => one.id);
}

const FINE = () => Response.json(said());

describe('an exercise while it is done', () => {
  it('says one thing, counts valid ones apart, and names every control', async () => {
    const { container, again } = show(<Exercise guidance={said()} />, FINE);
    expect(screen.getByTestId('line').textContent).toBe('Begin when you like');
    expect(screen.getByLabelText('Counted').textContent).toBe('2of 101 not quite far enough');
    again(<Exercise guidance={said({ status: 'moving', cue: 'Sit tall.', cue_number: 1 })} />);
    expect(screen.getByTestId('line').textContent).toBe('Sit tall.');
    for (const name of ['Pause', 'It hurts', 'Stop']) expect(screen.getByRole('button', { name })).toBeTruthy();
    expect(await faults(container)).toEqual([]);
    expect(analystWordsIn(container)).toEqual([]);
  });

  it('stops at once when it hurts, also where nobody can be told', async () => {
    const { container } = show(<Exercise guidance={said({ status: 'moving' })} />, () =>
      Promise.reject(new TypeError()),
    );
    await userEvent.click(screen.getByRole('button', { name: 'It hurts' }));
    expect(screen.getByRole('heading', { name: 'Stop and rest' })).toBeTruthy();
    expect(asked).toEqual([['POST /api/sessions/s/guidance', { command: 'pain' }]]);
    expect((await screen.findByRole('alert')).textContent).toContain('could not be reached');
    expect(await faults(container)).toEqual([]);
  });

  it('pauses by key, and goes on only when asked', async () => {
    const { again } = show(<Exercise guidance={said()} />, FINE);
    await userEvent.keyboard('{Escape}');
    expect(screen.getByRole('heading', { name: 'Take a break' })).toBeTruthy();
    again(<Exercise guidance={said({ status: 'paused', cause: 'person' })} />);
    await userEvent.click(screen.getByRole('button', { name: 'Go on' }));
    await waitFor(() => expect(asked.at(-1)).toEqual(['POST /api/sessions/s/guidance', { command: 'resume' }]));
    again(<Exercise guidance={said({ status: 'waiting' })} />);
    await waitFor(() =>
      expect(screen.getByTestId('line').textContent).toBe('Stand as at the beginning and rest for a moment'),
    );
  });

  it('offers a rest after a set, and says how much is left of what is prescribed', async () => {
    show(<Exercise guidance={said({ status: 'paused', cause: 'set', goal: 3 })} />, FINE);
    expect(screen.getByRole('heading', { name: 'Well done. Rest a moment' })).toBeTruthy();
    expect(screen.getByText('1 more for today. Go on when you are ready.')).toBeTruthy();
    expect(screen.queryByText('All done!')).toBeNull();
    const choices = screen.getAllByRole('button').map((one) => one.textContent);
    expect(choices.indexOf('Go on')).toBeLessThan(choices.indexOf('Finish for today'));
    await userEvent.click(screen.getByRole('button', { name: 'Go on' }));
    await waitFor(() => expect(asked.at(-1)).toEqual(['POST /api/sessions/s/guidance', { command: 'resume' }]));
  });

  it('never says that more was done of less', () => {
    const beyond = { valid: 5, partial: 0, wrong: 0 };
    const { again } = show(<Exercise guidance={said({ goal: 5, counts: beyond })} />, FINE);
    expect(screen.getByLabelText('Counted').textContent).toBe('5of 5');
    again(<Exercise guidance={said({ goal: 4, counts: beyond })} />);
    expect(screen.getByLabelText('Counted').textContent).toBe('5goal of 4 reached');
  });

  it('asks before it ends', async () => {
    show(<Exercise guidance={said()} />, FINE);
    await userEvent.click(screen.getByRole('button', { name: 'Stop' }));
    expect(onFinish).not.toHaveBeenCalled();
    await userEvent.click(screen.getByRole('button', { name: 'Finish for today' }));
    expect(onFinish).toHaveBeenCalledOnce();
  });

  it('has words for every reason of the service', () => {
    const causes = [
      'person',
      'pain',
      'limit',
      'valid_count',
      'set',
      'attempt_count',
      'time',
      'lost',
      'unsure',
      'wrong_in_a_row',
    ];
    const held = causes.map((cause) => heldBy(said({ status: 'paused', cause: cause as GuidanceMessage['cause'] })));
    expect(held).toEqual([
      'person',
      'pain',
      'limit',
      'done',
      'set',
      'enough',
      'time',
      'lost',
      'lost',
      'wrong_in_a_row',
    ]);
    expect(heldBy(said())).toBeNull();
  });

  it('counts aloud only after somebody asked for it', async () => {
    const spoken: string[] = [];
    vi.stubGlobal(
      'SpeechSynthesisUtterance',
      class {
        lang = '';
        constructor(readonly text: string) {}
      },
    );
    vi.stubGlobal('speechSynthesis', {
      cancel: () => undefined,
      speak: (one: { text: string }) => spoken.push(one.text),
    });
    const { again } = show(<Exercise guidance={said()} />, FINE);
    again(<Exercise guidance={said({ counts: { valid: 3, partial: 1, wrong: 0 } })} />);
    expect(spoken).toEqual([]);
    await userEvent.click(screen.getByRole('switch', { name: 'Count aloud' }));
    again(<Exercise guidance={said({ counts: { valid: 4, partial: 1, wrong: 0 } })} />);
    again(<Exercise guidance={said({ counts: { valid: 4, partial: 1, wrong: 0 }, cue: 'Slower.', cue_number: 1 })} />);
    expect(spoken).toEqual(['4', 'Slower.']);
  });

  it('counts what was done earlier today', () => {
    const { again } = show(
      <Exercise guidance={said({ before: 4, counts: { valid: 2, partial: 0, wrong: 0 } })} />,
      FINE,
    );
    const count = screen.getByLabelText('Counted');
    // Large is this round, small the day; both go on beyond the goal.
    expect(count.textContent).toBe('26 of 10 today');
    again(<Exercise guidance={said({ goal: 6, before: 201, counts: { valid: 3, partial: 0, wrong: 0 } })} />);
    expect(screen.getByLabelText('Counted').textContent).toBe('3204 today, goal of 6 reached');
  });

  it('says in a break what is left of the day', () => {
    const held = said({ status: 'paused', cause: 'set', before: 4, counts: { valid: 2, partial: 0, wrong: 0 } });
    show(<Exercise guidance={held} />, FINE);
    expect(screen.getByText(/4 more/).textContent).toBeTruthy();
  });
});

describe('the questions after it', () => {
  const session = { id: 's', patient_id: 'p', exercise_id: 'e', events: [] } as unknown as SessionDetail;
  const empty = {
    pain: null,
    effort: null,
    third: null,
    note: '',
    question: 'Was the shoulder steady?',
    answered_at: null,
  };

  it('takes two taps, the question of the therapist, and says thank you', async () => {
    const { container } = show(<After session={session} guidance={said()} />, (path, body) => {
      if (!path.endsWith('/answers')) return Response.json({ measures: [] });
      return Response.json(body ? { ...empty, ...(body as object), answered_at: '2026-11-25T18:00:00Z' } : empty);
    });
    await screen.findByRole('group', { name: 'Was the shoulder steady?' });
    expect(screen.getByText('You did 2 good movements.')).toBeTruthy();
    expect(await faults(container)).toEqual([]);
    expect(analystWordsIn(container)).toEqual([]);
    for (const [name, mark] of [
      ['Did it hurt?', 1],
      ['How hard was it?', 6],
    ] as const) {
      const group = screen.getByRole('group', { name });
      await userEvent.click(group.querySelectorAll('input')[mark]!);
    }
    await userEvent.click(screen.getByRole('button', { name: 'Send to my therapist' }));
    expect(asked.at(-1)).toEqual(['PUT /api/sessions/s/answers', { pain: 1, effort: 6 }]);
    expect(await screen.findByText('Thank you. Your therapist can read it.')).toBeTruthy();
  });

  it('thanks who stopped because it hurt, and does not ask whether it did', async () => {
    const events = [{ kind: 'pain', sentences: {} }] as unknown as SessionDetail['events'];
    show(<After session={{ ...session, events }} guidance={null} />, (path, body) =>
      path.endsWith('/answers')
        ? Response.json(body ? { ...empty, ...(body as object), answered_at: '2026-11-25T18:00:00Z' } : empty)
        : Response.json({ measures: [] }),
    );
    const group = await screen.findByRole('group', { name: 'How much did it hurt?' });
    expect(screen.queryByText(/That counts/)).toBeNull();
    const marks = [...group.querySelectorAll('input')].map((one) => one.value);
    expect(marks).toEqual(['1', '2', '3', '4', '5', '6', '7', '8', '9', '10']);
    await userEvent.click(group.querySelectorAll('input')[5]!);
    await userEvent.click(screen.getByRole('button', { name: 'Send to my therapist' }));
    expect(asked.at(-1)).toEqual(['PUT /api/sessions/s/answers', { pain: 6 }]);
  });

  it('keeps the buttons after pain where they are when it becomes known', async () => {
    const { again } = show(<Exercise guidance={said()} />, FINE);
    await userEvent.click(screen.getByRole('button', { name: 'It hurts' }));
    const known = await screen.findByText('Your therapist sees that it hurt.');
    const held = said({ status: 'stopped', cause: 'pain' });
    again(<Exercise guidance={held} />);
    // Its line was there before: nothing has come in above the buttons.
    expect(screen.getByText('Your therapist sees that it hurt.')).toBe(known);
    expect(known.getAttribute('aria-hidden')).not.toBe('true');
  });

  it('knows what was counted after the page was loaded again', async () => {
    const told = (kind: string, code: string) => ({ kind, sentences: { text: { code, params: { number: 1 } } } });
    const events = [
      told('repetition', 'guided.valid'),
      told('repetition', 'guided.partial'),
      told('cue', 'guidance.further'),
      told('repetition', 'guided.valid'),
      told('repetition', 'guided.valid'),
      { kind: 'state', sentences: {} },
    ] as unknown as SessionDetail['events'];
    show(<After session={{ ...session, events }} guidance={null} />, (path) =>
      Response.json(path.endsWith('/answers') ? empty : { measures: [] }),
    );
    expect(await screen.findByText('You did 3 good movements.')).toBeTruthy();
  });
});

describe('the moment of a session', () => {
  const session = { state: 'closing', pipeline: 'arm', recording_start_s: 1, recording_end_s: 9 } as const;
  const snapshot = {
    state: { state: 'analysed' },
    connection: 'open',
    silentSinceS: null,
    calibration: null,
  } as unknown as Parameters<typeof momentOf>[0];

  it('is over for the page when its result can be opened, not when the socket has heard of it', () => {
    expect(momentOf(snapshot, session)).toBe('preparing');
    expect(momentOf(snapshot, { ...session, state: 'analysed' })).toBe('done');
  });
});
