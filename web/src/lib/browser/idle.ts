// How long nobody has touched keyboard, mouse or screen in any tab of this browser. The service hears it with each
// request: what pages ask by themselves does not keep a person signed in.
const KEY = 'telemotion.used';
const INPUTS = ['pointerdown', 'pointermove', 'keydown', 'wheel', 'touchstart'] as const;
const NOTED_EVERY_MS = 1000;

let usedAt = Date.now();

/** Note that somebody is here. */
export function noteUse(): void {
  const now = Date.now();
  if (now - usedAt < NOTED_EVERY_MS) return;
  usedAt = now;
  try {
    localStorage.setItem(KEY, String(now));
  } catch {
    // Without storage each tab counts for itself.
  }
}

/** Seconds since somebody was last here. */
export function idleSeconds(): number {
  let latest = usedAt;
  try {
    latest = Math.max(latest, Number(localStorage.getItem(KEY)) || 0);
  } catch {
    // As above.
  }
  return Math.max(0, Math.floor((Date.now() - latest) / 1000));
}

/** Listen to the inputs of a window, also of a 3D view's frame; returns how to stop. */
export function listenForUse(target: Window): () => void {
  for (const input of INPUTS) target.addEventListener(input, noteUse, { passive: true, capture: true });
  return () => {
    for (const input of INPUTS) target.removeEventListener(input, noteUse, { capture: true });
  };
}
