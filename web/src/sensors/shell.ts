// The client's own files stay on the device, so that a page opens without a link; nothing of a patient does.

/** Register the worker that keeps the shell; does nothing where there is none. */
export function registerShell(): void {
  if (!import.meta.env.PROD || !('serviceWorker' in navigator)) return;
  // Without it everything works but opening the page without a link.
  navigator.serviceWorker.register('/sw.js').catch(() => undefined);
}
