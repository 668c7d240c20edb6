import { screen, within } from '@testing-library/react';
import axe from 'axe-core';
import { afterEach, describe, expect, it, vi } from 'vitest';
import type { MarkerReport, Markers, SessionDetail } from '../../../src/api/types';
import { MarkersPanel } from '../../../src/pages/session/replay/MarkersPanel';
import { renderPage } from '../render';

afterEach(() => vi.unstubAllGlobals());

const REPORT: MarkerReport = {
  marker: 'HAND',
  offset_s: 0.0123,
  offset_sigma_s: 0.0001,
  drift_ppm: 80,
  drift_sigma_ppm: 0.4,
  correlation: 0.998,
  rival: 0.56,
  overlap_s: 58,
  aligned_by: 'acceleration',
  lever_arm_m: [0.04, -0.03, 0.05],
  lever_arm_sigma_m: [0.001, 0.001, 0.00003],
  heading_sigma_rad: 0.01,
  residual_rms_m: [0.0003, 0.0003, 0.0004],
  sigma_scale: 1,
  mean_nis: 3,
  frame_count: 100,
  used_count: 98,
  rejected_count: 2,
  gaps: [{ start_s: 9, length_s: 3.5, sigma_m: 0.0061, withheld: true }],
  gap_count: 1,
  checks: [{ length_s: 0.5, count: 12, inertial_m: 0.0011, spline_m: 0.052, within_three_sigma: 1 }],
  curves: { time_s: [0, 1], residual_m: [0.0003, null], sigma_m: [0.0002, 0.006], speed_mps: [0.1, 0.2] },
  reasons: [],
};
const FOUND: Markers[] = [
  {
    id: 'm',
    session_id: 's',
    segment: 'hand_right',
    format: 'csv',
    file_bytes: 5,
    uploaded_at: null,
    status: 'complete',
    message: '',
    report: REPORT,
  },
  {
    id: 'n',
    session_id: 's',
    segment: 'hand_right',
    format: 'c3d',
    file_bytes: 5,
    uploaded_at: null,
    status: 'failed',
    message: 'They do not fit this sensor.',
    report: null,
  },
];
const session = (mayTreat: boolean) =>
  ({
    id: 's',
    placements: ['sternum', 'hand_right'],
    state: 'analysed',
    may_treat: mayTreat,
  }) as unknown as SessionDetail;
const show = (mayTreat: boolean, found: Markers[]) =>
  renderPage(<MarkersPanel session={session(mayTreat)} />, {
    at: '/s',
    path: '/s',
    answers: { '/api/sessions/s/markers': found },
  });

describe('markers of a session', () => {
  it('shows clocks, gaps, residuals and what a spline would have made, and tells what failed', async () => {
    const view = show(true, FOUND);
    expect(await screen.findByText('12.3 ± 0.1 ms, drift 80.0 ± 0.4 ppm')).toBeTruthy();
    expect(screen.getByText('40.0 ± 1.0 / −30.0 ± 1.0 / 50.00 ± 0.03 mm')).toBeTruthy();
    expect(screen.getByText('1, the longest 3.50 s, uncertainty 6.1 mm')).toBeTruthy();
    expect(screen.getByText(/an uncertainty above 10 mm/)).toBeTruthy();
    expect(screen.getByRole('img', { name: /largest residual 0\.3 mm/ })).toBeTruthy();
    const row = screen.getByRole('row', { name: /^0\.5 s/ });
    expect(
      within(row)
        .getAllByRole('cell')
        .map((cell) => cell.textContent),
    ).toEqual(['12', '1.1 mm', '52.0 mm']);
    expect(screen.getByText(/They do not fit this sensor/)).toBeTruthy();
    expect(screen.getByRole('button', { name: 'Upload and fuse' })).toHaveProperty('disabled', true);
    expect(screen.getByRole('link', { name: /Download the fused motion/ }).getAttribute('href')).toBe(
      '/api/sessions/s/markers/motion?markers_id=m',
    );
    const rules = {
      'color-contrast': { enabled: false },
      region: { enabled: false },
      'page-has-heading-one': { enabled: false },
      'heading-order': { enabled: false },
    };
    const checked = await axe.run(view.container, { rules });
    expect(checked.violations.map((one) => one.id)).toEqual([]);
  });

  it('offers no upload to those who may not analyse', async () => {
    show(false, []);
    expect(await screen.findByText('No markers yet.')).toBeTruthy();
    expect(screen.queryByRole('button', { name: 'Upload and fuse' })).toBeNull();
  });
});
