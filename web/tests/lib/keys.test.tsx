import { render, screen } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { expect, it, vi } from 'vitest';
import { useKeys } from '../../src/lib/browser/keys';

function Page({ play }: { play: () => void }) {
  useKeys({ ' ': play });
  return (
    <>
      <p>Curves</p>
      <input aria-label="Note" />
      <input aria-label="Time" type="range" />
      <button type="button">Other</button>
    </>
  );
}

it('plays with the space bar wherever the focus is, and does not scroll the page', async () => {
  const play = vi.fn();
  const { unmount } = render(<Page play={play} />);
  // Nothing has the focus: this scrolled the page before.
  expect(document.activeElement).toBe(document.body);
  const event = new KeyboardEvent('keydown', { key: ' ', bubbles: true, cancelable: true });
  document.body.dispatchEvent(event);
  expect(event.defaultPrevented).toBe(true);
  expect(play).toHaveBeenCalledTimes(1);
  screen.getByLabelText('Time').focus();
  await userEvent.keyboard(' ');
  expect(play).toHaveBeenCalledTimes(2);
  unmount();
  document.body.dispatchEvent(new KeyboardEvent('keydown', { key: ' ', bubbles: true }));
  expect(play).toHaveBeenCalledTimes(2);
});

it('leaves the key to fields and buttons', async () => {
  const play = vi.fn();
  render(<Page play={play} />);
  await userEvent.type(screen.getByLabelText('Note'), 'a b');
  expect(screen.getByLabelText('Note')).toHaveProperty('value', 'a b');
  screen.getByRole('button').focus();
  await userEvent.keyboard(' ');
  expect(play).not.toHaveBeenCalled();
});
