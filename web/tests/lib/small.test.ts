import { render } from '@testing-library/react';
import { createElement } from 'react';
import { describe, expect, it } from 'vitest';
import type {
  AuditEntry,
  CaseloadRow,
  MeasureValue,
  Placement,
  ProgressMeasure,
  SessionDetail,
} from '../../src/api/types';
import { runs, steadyRange } from '../../src/charts/scales';
import { groupAudit } from '../../src/lib/audit';
import { holdsWords, matches } from '../../src/lib/assessment/caseload';
import { nearOf } from '../../src/kinds';
import { limbOf, placementProblem, suggestedPlacements } from '../../src/lib/placements';
import { jointOf, mainMeasure, plainFeedback, plainProgress } from '../../src/lib/plain';
import { changed, trend } from '../trend';
import type { SessionEvent } from '../../src/api/types';
import { eventText } from '../../src/lib/events';
import { WearPicture } from '../../src/pictures/WearPicture';

const row = (
  given_name: string,
  family_name: string,
  reason: CaseloadRow['reason'],
  live_state: CaseloadRow['live_state'] = null,
) => ({ given_name, family_name, reason, live_state }) as CaseloadRow;

describe('caseload', () => {
  const rows = [
    row('Ana', 'Zuber', ''),
    row('José', 'Núñez', 'declining'),
    row('Bo', 'Abt', 'link_lost', 'link_lost'),
    row('Li', 'Mo', '', 'streaming'),
  ];
  it('finds names without accents, in any order', () => {
    expect(rows.filter((one) => matches(one, 'all', 'nunez jos')).map((one) => one.given_name)).toEqual(['José']);
  });
  it.each([
    [
      'O’Brien van der Berg-Łukasiewicz',
      ["O'Brien", 'OBrien', 'o’brien', 'lukasiewicz', 'berg', 'berg luk', 'vanderberg'],
    ],
    ['Weiß-Møller', ['weiss', 'Weiß', 'moller', 'moeller', 'MØLLER', 'weiss-moller', 'weissmoller']],
    ['Jürgen Groß', ['juergen', 'jurgen', 'Jürgen gross', 'gros']],
    ['Mueller', ['Müller', 'mueller']],
    ['Þóra Guðmundsdóttir', ['thora', 'gudmunds']],
    ['Đorđe Ćosić', ['dorde cosic']],
    ['D´Angelo N‘Diaye', ['dangelo', "n'diaye", 'ndiaye']],
  ])('finds %s as people type it', (name, typed) => {
    for (const words of typed) expect(holdsWords(name, words), words).toBe(true);
    expect(holdsWords(name, 'smith')).toBe(false);
    expect(holdsWords(name, '')).toBe(true);
  });
  it('does not find what is written otherwise', () => {
    expect(holdsWords('Jan Nagel', 'anna')).toBe(false);
    expect(holdsWords('Muller', 'Mahler')).toBe(false);
  });
  it('counts a dead link among those who need a look, and never as live', () => {
    expect(rows.filter((one) => matches(one, 'look', '')).map((one) => one.family_name)).toEqual(['Núñez', 'Abt']);
    expect(rows.filter((one) => matches(one, 'live', '')).map((one) => one.family_name)).toEqual(['Mo']);
  });
});

describe('audit', () => {
  const entry = (at: string, who: string, action: string): AuditEntry => ({
    at,
    who,
    action,
    role: 'therapist',
    resource_id: null,
    details: {},
  });
  it('makes one line of a person and a day and loses no deed', () => {
    const entries = [
      entry('2025-01-01T10:00:00', 'A', 'patient.read'),
      entry('2025-01-01T10:10:00', 'A', 'patient.read'),
      entry('2025-01-01T08:00:00', 'A', 'session.read'),
      entry('2025-01-01T10:05:00', 'B', 'patient.read'),
      entry('2025-01-02T10:05:00', 'A', 'patient.read'),
    ];
    const groups = groupAudit(entries);
    expect(groups.map((group) => [group.who, group.deeds])).toEqual([
      ['A', [{ action: 'patient.read', count: 1 }]],
      [
        'A',
        [
          { action: 'patient.read', count: 2 },
          { action: 'session.read', count: 1 },
        ],
      ],
      ['B', [{ action: 'patient.read', count: 1 }]],
    ]);
    expect(groups[1]).toMatchObject({ first: '2025-01-01T08:00:00', last: '2025-01-01T10:10:00' });
    expect(groups.flatMap((group) => group.deeds).reduce((sum, deed) => sum + deed.count, 0)).toBe(entries.length);
  });
});

describe('placements', () => {
  it('wants a chain without holes', () => {
    expect(placementProblem(['sternum', 'thigh_left'])).toBe('placements.needLegs');
    expect(placementProblem(['pelvis', 'thigh_left', 'thigh_right'])).toBeNull();
    expect(placementProblem(['thigh_left', 'shank_left'])).toBeNull();
    expect(placementProblem(['pelvis', 'shank_left', 'foot_left'])).toBeNull();
    expect(placementProblem(['pelvis', 'thigh_left', 'hand_left'])).toBe('placements.needUpperArm');
    expect(placementProblem(['thigh_left', 'shank_right'])).toBe('placements.needLegs');
    expect(placementProblem(['sternum'])).toBe('placements.needArm');
    expect(placementProblem(['forearm_left'])).toBe('placements.needUpperArm');
    expect(placementProblem(['upper_arm_left', 'hand_left'])).toBe('placements.needForearm');
    expect(placementProblem(['upper_arm_left', 'forearm_left', 'hand_left'])).toBeNull();
  });
});

describe('what is worn at home', () => {
  it('is the arm of the affected side, or the leg whose angle counts', () => {
    expect(suggestedPlacements('left')).toEqual(['sternum', 'upper_arm_left', 'forearm_left', 'hand_left']);
    expect(suggestedPlacements('left', 'humerus_forearm_right_zxy_flexion')).toEqual(suggestedPlacements('left'));
    const leg = suggestedPlacements('left', 'thigh_shank_right_zxy_flexion');
    expect(leg).toEqual(['sternum', 'pelvis', 'thigh_right', 'shank_right', 'foot_right']);
    expect(placementProblem(leg)).toBeNull();
  });
});

describe('what a session is of', () => {
  it('is a leg where legs are measured and no arm is: the nearest view goes there', () => {
    const near = (placements: string[], pipeline = 'arm') => nearOf({ pipeline, placements } as SessionDetail);
    expect(near(suggestedPlacements('left', 'pelvis_thigh_left_zxy_abduction'))).toBe('leg');
    expect(near(suggestedPlacements('left'))).toBe('arm');
    expect(near(['upper_arm_left', 'thigh_left', 'shank_left'])).toBe('arm');
    expect(near(['foot_left', 'foot_right'], 'gait')).toBe('feet');
    expect(limbOf('shank_foot_left_zxy_inversion')).toBe('leg');
    expect(limbOf('thorax_humerus_left_yxy_elevation')).toBe('arm');
  });
  it('is what the picture of the places has in colour', () => {
    const coloured = (placements: Placement[]) =>
      [
        ...render(createElement(WearPicture, { placements, label: 'Places' })).container.querySelectorAll('path'),
      ].filter((one) => one.closest('.figure-moves')).length;
    // Three parts of an arm, three of a leg.
    expect(coloured(['sternum', 'upper_arm_right', 'forearm_right'])).toBe(3);
    expect(coloured(suggestedPlacements('left', 'thigh_shank_left_zxy_flexion'))).toBe(3);
    expect(coloured(['sternum'])).toBe(0);
  });
});

describe('plain words', () => {
  it('name the joint of a leg', () => {
    expect(jointOf('range:thigh_shank_right_zxy_flexion')).toBe('knee');
    expect(jointOf('range:pelvis_thigh_left_zxy_abduction')).toBe('hip');
    expect(jointOf('range:shank_foot_left_zxy_flexion')).toBe('ankle');
    expect(jointOf('range:humerus_forearm_left_zxy_flexion')).toBe('elbow');
  });
  const DAY = '2026-01-01T00:00:00Z';
  const measure = (words: ProgressMeasure['trend'], name = 'range:elbow', unit = 'rad'): ProgressMeasure => ({
    measure: name,
    label: 'Elbow',
    unit,
    points: Array.from({ length: 4 }, () => ({
      session_id: 's',
      at: DAY,
      value: 1,
      low: 1,
      high: 1,
      count: 5,
      orientation: 'vqf',
      template_version_id: null,
    })),
    trend: { ...words, since: DAY },
    bands: [],
  });
  it('tells a change where it is sure, and nothing where little is known', () => {
    const moved = (word: ProgressMeasure['trend']['word'], now = 0.84) =>
      plainProgress(measure(changed(0.7, now, 0.1, { word })));
    expect(moved('more')).toBe('Your joint moves 8° more than at the beginning.');
    expect(moved('less', 0.56)).toMatch(/^Your joint moves 8° less than .* Your therapist sees this too/);
    expect(moved('a_little_more')).toBe('A little more than at the beginning.');
    expect(moved('probably_more')).toMatch(/^It looks like more/);
    expect(moved('unchanged')).toBe('As at the beginning.');
    expect(moved('unknown')).toBeNull();
    expect(moved('probably_less')).toBeNull();
    expect(plainProgress(measure(trend()))).toBeNull();
    expect(plainProgress(null)).toMatch(/After your first/);
  });
  it('names the beginning, or the eight weeks that a trend looks back', () => {
    const elbow = measure(changed(39, 59, 5), 'range:humerus_forearm_left_zxy_flexion', 'deg');
    expect(plainProgress(elbow)).toBe('Your elbow opens 20° more than at the beginning.');
    const later = { ...elbow, trend: { ...elbow.trend, since: '2026-03-01T00:00:00Z' } };
    expect(plainProgress(later)).toBe('Your elbow opens 20° more than eight weeks ago.');
  });

  it('says of a walk what became more or less', () => {
    const walked = (name: string, unit: string, change: number) =>
      plainProgress(measure(changed(100, 100 + change, 0.1), `walk:${name}`, unit));
    expect(walked('test_time', 's', 2.24)).toBe(
      'Your walk takes 2.2 s more than at the beginning. Your therapist sees this too.',
    );
    expect(walked('test_time', 's', -2.24)).toBe('Your walk takes 2.2 s less than at the beginning.');
    expect(walked('test_distance', 'metres', 31.4)).toBe('You walk 31 m further than at the beginning.');
    expect(walked('speed:left', 'm/s', -0.2)).toMatch(/^You walk more slowly/);
    expect(walked('step_width', 'm', 0.02)).toMatch(/^Your results are not as at the beginning/);
  });
});

describe('scales', () => {
  it('holds the values in whole steps and is never too narrow', () => {
    expect(steadyRange(12, 87, 20, 40)).toEqual([0, 100]);
    const [low, high] = steadyRange(41, 42, 20, 40);
    expect(high - low).toBeGreaterThanOrEqual(40);
    expect(low).toBeLessThanOrEqual(41);
    expect(high).toBeGreaterThanOrEqual(42);
  });
  it('finds half-open runs', () => {
    const marks = [0, 1, 1, 0, 1];
    expect(runs(marks.length, (index) => marks[index] === 1)).toEqual([
      [1, 3],
      [4, 5],
    ]);
  });
});

describe('what happened', () => {
  const event = (change: Partial<SessionEvent>): SessionEvent =>
    ({ time_s: 1, kind: 'note', ...change }) as SessionEvent;
  it('is told with the plain name of a sensor', () => {
    expect(eventText(event({ placement: 'hand_right', text: 'hand_right: the magnetic field varies' }))).toBe(
      'Right hand: the magnetic field varies',
    );
    expect(eventText(event({ placement: 'hand_right', text: 'Iron is near' }))).toBe('Iron is near');
    expect(eventText(event({ kind: 'device_calibration', text: '' }))).toBe('A sensor was calibrated in the hand');
  });
});

describe('strides beside a template', () => {
  it('are of a foot, and are told to a patient without numbers of a joint', () => {
    expect(limbOf('foot_height_right_m')).toBe('foot');
    const summary = [{ measure: 'range:foot_pitch_right_rad', value: 60, unit: 'deg' } as MeasureValue];
    expect(plainFeedback(summary, 6, '')).toEqual(['6 of your strides were compared with the example.']);
  });
  it('come after the numbers of the walk', () => {
    const of = (measure: string) => ({ measure, points: [{}] }) as ProgressMeasure;
    expect(mainMeasure([of('walk:speed:left'), of('range:foot_pitch_left_rad')])?.measure).toBe('walk:speed:left');
  });
});
