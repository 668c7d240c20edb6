// Keys that work wherever the focus is on the page, except where a key means something already.
import { useEffect, useRef } from 'react';

const TYPED_INTO = 'textarea, select, [contenteditable], [role=option], [role=listbox], [role=menu], [role=dialog]';
const WRITTEN = new Set(['text', 'search', 'number', 'email', 'password', 'date', 'tel', 'url', 'time']);
/** What the space bar does something to by itself. */
const PRESSED = 'button, a, summary, [role=tab], [role=button], input[type=checkbox], input[type=radio]';

/** Whether a key pressed here belongs to the element and not to the page. */
export function belongsTo(target: EventTarget | null, key: string): boolean {
  if (!(target instanceof Element)) return false;
  if (target.closest(TYPED_INTO)) return true;
  if (target instanceof HTMLInputElement && WRITTEN.has(target.type)) return true;
  return key === ' ' && target.closest(PRESSED) !== null;
}

/** Listen to keys of the whole document; a key that is held down counts once. */
export function useKeys(deeds: Readonly<Record<string, () => void>>): void {
  const latest = useRef(deeds);
  latest.current = deeds;
  useEffect(() => {
    const press = (event: KeyboardEvent) => {
      const deed = latest.current[event.key.toLowerCase()];
      if (
        !deed ||
        event.ctrlKey ||
        event.metaKey ||
        event.altKey ||
        event.defaultPrevented ||
        belongsTo(event.target, event.key)
      )
        return;
      event.preventDefault();
      if (!event.repeat) deed();
    };
    document.addEventListener('keydown', press);
    return () => document.removeEventListener('keydown', press);
  }, []);
}

/** Pass keys pressed inside a frame of our own on to the page around it. */
export function passKeysOn(frame: HTMLIFrameElement): void {
  frame.contentWindow?.addEventListener('keydown', ({ key, ctrlKey, metaKey, altKey, repeat }) => {
    document.dispatchEvent(
      new KeyboardEvent('keydown', { key, ctrlKey, metaKey, altKey, repeat, bubbles: true, cancelable: true }),
    );
  });
}
