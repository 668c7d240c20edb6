import { MantineProvider } from '@mantine/core';
import { render, screen } from '@testing-library/react';
import { expect, test } from 'vitest';
import type { HealthMessage } from '../../../src/api/types';
import { NotStored } from '../../../src/pages/session/live/NotStored';

const HEALTH: HealthMessage = {
  type: 'health',
  sensors: [],
  packets_received: 20,
  packets_stored: 10,
  packets_missing: 0,
  is_being_stored: false,
  latency_ms_median: null,
  latency_ms_p99: null,
  clock_skew_ppm: null,
};

function show(health: HealthMessage | null) {
  return render(
    <MantineProvider>
      <NotStored health={health} />
    </MantineProvider>,
  );
}

test('says that nothing is stored, in words that need no training', () => {
  show(HEALTH);
  expect(screen.getByRole('alert').textContent).toContain('Not being stored');
});

test('says nothing while all is stored or not known', () => {
  show({ ...HEALTH, is_being_stored: true });
  show(null);
  expect(screen.queryByRole('alert')).toBeNull();
});
