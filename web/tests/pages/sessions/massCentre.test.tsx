// What a session says of the centre of mass, and when it says that it cannot.
import { cleanup, screen } from '@testing-library/react';
import { afterEach, describe, expect, it } from 'vitest';
import type { Series } from '../../../src/api/types';
import { massChannels } from '../../../src/lib/assessment/massCentre';
import { MassFacts } from '../../../src/pages/session/replay/MassFacts';
import { renderPage } from '../render';

afterEach(cleanup);

const at = '/api/sessions/s/series?names=mass_centre&result_id=r&max_points=1000';
const curve = (name: string, low: number | null, high: number | null) => ({
  series: 'mass_centre',
  name: `centre_of_mass_${name}_m`,
  unit: 'm',
  value: [low, high],
  sigma: [0.012, null, 0.014],
  least: low,
  most: high,
});
const found: Series = {
  result_id: 'r',
  time_s: [0, 1, 2],
  curves: [curve('ahead', -0.01, 0.05), curve('left', null, null), curve('height', 0.82, 0.96)],
  reasons: {},
  unworn: ['head', 'hand_left'],
  sentences: {},
};

describe('the centre of mass', () => {
  it('tells range, uncertainty and what is assumed', async () => {
    renderPage(<MassFacts sessionId="s" resultId="r" />, { answers: { [at]: found } });
    expect(await screen.findByText('Height of the centre of mass')).toBeTruthy();
    expect(screen.getByText(/82(.0)? cm to 96(.0)? cm|0.82 m to 0.96 m/)).toBeTruthy();
    expect(screen.getByText('not known')).toBeTruthy();
    expect(screen.getByText('Centre of mass to the left of the ankles')).toBeTruthy();
    expect(screen.getByText(/Without a sensor.*head, left hand/)).toBeTruthy();
  });

  it('says why there is none', async () => {
    const reason = 'The centre of mass needs sensors on both thighs and on the chest or the pelvis.';
    renderPage(<MassFacts sessionId="s" resultId="r" />, {
      answers: { [at]: { ...found, curves: [], reasons: { mass_centre: reason } } },
    });
    expect(await screen.findByText(reason)).toBeTruthy();
  });

  it('shows places, not their uncertainties, as channels', () => {
    expect(
      massChannels([
        'trunk_lean_forward_rad',
        'centre_of_mass_ahead_m',
        'centre_of_mass_ahead_sigma_m',
        'centre_of_mass_height_m',
        'centre_of_mass_sigma_m',
      ]),
    ).toEqual(['centre_of_mass_ahead_m', 'centre_of_mass_height_m']);
  });
});
