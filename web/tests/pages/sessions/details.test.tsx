// Which result is shown is chosen under Details, beside what made it.
import { screen } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { afterEach, expect, it, vi } from 'vitest';
import type { Result, SessionDetail } from '../../../src/api/types';
import { DetailsPanel } from '../../../src/pages/session/replay/DetailsPanel';
import { renderPage } from '../render';

afterEach(() => vi.unstubAllGlobals());
Element.prototype.scrollIntoView = () => undefined;

const result = (id: string, kind: 'live' | 'offline') =>
  ({
    id,
    kind,
    status: 'complete',
    orientation: 'vqf',
    orientation_version: '2',
    created_at: '2026-11-20T10:00:00Z',
  }) as Result;

it('chooses the result that the replay shows', async () => {
  const session = {
    id: 's',
    pipeline: 'arm',
    started_at: '2026-11-20T10:00:00Z',
    created_at: '2026-11-20T10:00:00Z',
    duration_s: 60,
    placements: ['sternum'],
    rate_hz: 100,
    packets_stored: 0,
    packets_missing: 0,
    calibration: null,
    main_result_id: 'b',
    may_treat: false,
    results: [result('a', 'live'), result('b', 'offline')],
  } as unknown as SessionDetail;
  const estimators = [{ name: 'vqf', version: '2', title: 'VQF', description: '', parameters: [], is_offline: false }];
  const view = renderPage(<DetailsPanel session={session} resultId="b" />, {
    at: '/sessions/s?comparison=c',
    path: '/sessions/:sessionId',
    answers: { '/api/estimators': estimators },
  });
  await userEvent.click(screen.getByRole('combobox', { name: 'Estimated with' }));
  const options = await screen.findAllByRole('option', { hidden: true });
  expect(options).toHaveLength(2);
  await userEvent.click(options[0]!);
  // The comparison was one of the other result.
  expect(view.router.state.location.search).toBe('?result=a');
});
