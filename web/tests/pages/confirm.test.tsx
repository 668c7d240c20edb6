import { screen } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { expect, it, vi } from 'vitest';
import { Confirm } from '../../src/components/forms/Confirm';
import { renderPage } from './render';

const asked = async (isGrave?: boolean) => {
  const onConfirm = vi.fn();
  renderPage(
    <Confirm label="End" title="End it?" text="It ends." confirm="Yes, end" isGrave={isGrave} onConfirm={onConfirm} />,
    { answers: {} },
  );
  await userEvent.click(screen.getByRole('button', { name: 'End' }));
  const button = await screen.findByRole('button', { name: 'Yes, end' });
  return { button, onConfirm };
};

it('is red only where something is gone for good', async () => {
  const { button, onConfirm } = await asked();
  expect(button.getAttribute('style')).not.toContain('red');
  await userEvent.click(button);
  expect(onConfirm).toHaveBeenCalledOnce();
});

it('is red where it cannot be taken back', async () => {
  const { button } = await asked(true);
  expect(button.getAttribute('style')).toContain('red');
});
