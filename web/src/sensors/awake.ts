// The screen stays on while an exercise is measured: a phone that sleeps measures nothing.

/** Keep the screen awake until the returned function is called; `onChange` hears whether it is. */
export function keepAwake(onChange: (isAwake: boolean) => void): () => void {
  let lock: WakeLockSentinel | null = null;
  let isOver = false;
  const ask = async () => {
    if (isOver || document.visibilityState !== 'visible' || !('wakeLock' in navigator)) return;
    try {
      const got = await navigator.wakeLock.request('screen');
      if (isOver) return void got.release();
      lock = got;
      got.addEventListener('release', () => onChange(false));
      onChange(true);
    } catch {
      // A nearly empty battery refuses it: the page says that the screen may go dark.
      onChange(false);
    }
  };
  // The browser lets it go whenever the page is not seen.
  const seen = () => void ask();
  document.addEventListener('visibilitychange', seen);
  void ask();
  return () => {
    isOver = true;
    document.removeEventListener('visibilitychange', seen);
    void lock?.release();
  };
}
