// Whether this browser can draw in 3D: on remote desktops, and where the driver is on a list of bad ones, it cannot.

/** A context that was lost comes back within this time, or not at all. */
const BACK_WITHIN_MS = 4000;

/** Whether a 3D page would be drawn; the context made to ask is given back, because a browser has few of them. */
export function canDraw3D(): boolean {
  try {
    const context = document.createElement('canvas').getContext('webgl2');
    context?.getExtension('WEBGL_lose_context')?.loseContext();
    return context !== null;
  } catch {
    return false;
  }
}

/** Call when a 3D page in a frame of our own loses the graphics card for good. */
export function whenLostForGood(frame: HTMLIFrameElement, tell: () => void): void {
  const page = frame.contentDocument;
  let timer: ReturnType<typeof setTimeout> | undefined;
  // Both stop at the canvas: they are heard on their way down.
  page?.addEventListener(
    'webglcontextlost',
    () => {
      clearTimeout(timer);
      timer = setTimeout(() => frame.isConnected && tell(), BACK_WITHIN_MS);
    },
    true,
  );
  page?.addEventListener('webglcontextrestored', () => clearTimeout(timer), true);
}
