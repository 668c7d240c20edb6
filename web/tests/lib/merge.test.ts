import { describe, expect, it } from 'vitest';
import type { CueDesign, StopDesign, TemplateDesign } from '../../src/api/types';
import { designFields, designOfFields } from '../../src/lib/editing/designFields';
import { isSame, merge, type Fields } from '../../src/lib/editing/merge';

describe('merge', () => {
  const before = { sets: 1, repetitions: 10, question: '', end: null };

  it('takes mine over theirs only where I changed it, and asks where both did', () => {
    const joined = merge(
      before,
      { ...before, sets: 3, repetitions: 12, question: 'Pain?' },
      { ...before, repetitions: 20, end: '2026-12-24', question: 'Pain?' },
    );
    expect(joined.theirs.map((one) => one.field)).toEqual(['question', 'end']);
    expect(joined.forks).toEqual([{ field: 'repetitions', before: 10, mine: 12, theirs: 20 }]);
    expect(joined.merged({ repetitions: 'mine' })).toEqual({
      sets: 3,
      repetitions: 12,
      question: 'Pain?',
      end: '2026-12-24',
    });
    expect(joined.merged({}).repetitions, 'what is stored stands while nobody chose').toBe(20);
  });

  it('compares by value: order of keys, nulls and the last digits are no change', () => {
    expect(isSame({ a: 1, b: null }, { b: undefined, a: 1.00000004 })).toBe(true);
    expect(isSame([0, 1], [1, 0])).toBe(false);
    expect(isSame(undefined, 0)).toBe(false);
  });

  it('takes away what I took away, and keeps what they added', () => {
    const joined = merge({ 'cue:a': 1, 'cue:b': 2 }, { 'cue:b': 2 }, { 'cue:a': 1, 'cue:b': 2, 'cue:c': 3 });
    expect(joined.forks).toEqual([]);
    expect(Object.entries(joined.merged({})).filter(([, value]) => value !== undefined)).toEqual([
      ['cue:b', 2],
      ['cue:c', 3],
    ]);
  });
});

it('cuts a design into fields and puts it together again, two rules alike included', () => {
  const cue = (words: string): CueDesign => ({
    quantity: 'deviation',
    sentence: 'guidance.further',
    channel: 'a',
    words,
  });
  const design: TemplateDesign = {
    phases: [{ name: 'Out', start: 0, end: 1 }],
    tolerances: [{ channel: 'a', knots: [{ phase: 0, below: null, above: 2 }] }],
    watched: ['b'],
    stops: [{ kind: 'limit', channel: 'a', side: 'above', limit: 1, hold_s: 0.05 }],
    cues: [cue('Up'), cue('Higher')],
    valid_share: 0.8,
    pace: { silence_s: 2 },
    weights: [{ measure: 'duration', weight: -1 }],
  };
  const again = designOfFields(designFields(design), {});
  expect(again).toEqual({ ...design, pace: { silence_s: 2 } });
});

describe('two rules of one curve and side', () => {
  const limit = (value: number, hold_s: number): StopDesign => ({
    kind: 'limit',
    channel: 'a',
    side: 'above',
    limit: value,
    hold_s,
  });
  const slow = limit(1, 2);
  const atOnce = limit(1.5, 0);
  const joined = (before: StopDesign[], mine: StopDesign[], theirs: StopDesign[]) => {
    const opened = { stops: before };
    return merge(
      designFields(opened, opened),
      designFields({ stops: mine }, opened),
      designFields({ stops: theirs }, opened),
    );
  };
  const stopsOf = (fields: Fields) => designOfFields(fields, {}).stops;

  it('never drops a limit that nobody deleted, whichever is chosen', () => {
    const found = joined([slow, atOnce], [atOnce], [limit(1.1, 2), atOnce]);
    expect(found.forks.map(({ mine, theirs }) => [mine, theirs])).toEqual([[undefined, limit(1.1, 2)]]);
    expect(stopsOf(found.merged({ [found.forks[0]!.field]: 'mine' }))).toEqual([atOnce]);
    expect(stopsOf(found.merged({ [found.forks[0]!.field]: 'theirs' }))).toEqual([limit(1.1, 2), atOnce]);
  });

  it('keeps a rule that was put in front apart from the one behind it', () => {
    const found = joined([slow], [limit(0.8, 0), slow], [limit(1.2, 2)]);
    expect(found.forks).toEqual([]);
    expect(stopsOf(found.merged({}))).toEqual([limit(1.2, 2), limit(0.8, 0)]);
  });

  it('takes the one that was changed for the one it is most like', () => {
    const found = joined([slow, atOnce], [limit(1.6, 0)], [limit(1.1, 2), atOnce]);
    expect(found.forks.map(({ mine, theirs }) => [mine, theirs])).toEqual([[undefined, limit(1.1, 2)]]);
    expect(stopsOf(found.merged({}))).toEqual([limit(1.1, 2), limit(1.6, 0)]);
  });
});
