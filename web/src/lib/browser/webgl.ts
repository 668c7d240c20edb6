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
  let isLost = false;
  // A device that is locked, or shows another page, takes the card away and gives it back to the page that is seen.
  const count = () => {
    clearTimeout(timer);
    if (!frame.isConnected || frame.contentDocument !== page) isLost = false;
    if (!isLost) document.removeEventListener('visibilitychange', count);
    else if (document.visibilityState === 'visible')
      timer = setTimeout(() => {
        document.removeEventListener('visibilitychange', count);
        if (frame.isConnected && frame.contentDocument === page) tell();
      }, BACK_WITHIN_MS);
  };
  // Both stop at the canvas: they are heard on their way down.
  page?.addEventListener(
    'webglcontextlost',
    () => {
      isLost = true;
      document.addEventListener('visibilitychange', count);
      count();
    },
    true,
  );
  page?.addEventListener(
    'webglcontextrestored',
    () => {
      isLost = false;
      count();
    },
    true,
  );
}

/** A picture of this width and height is enough to see whether something stands in the view. */
const SIDE_PX = 120;
/** More of it than the three lines of an empty scene, less than two shoes. */
const DRAWN_SHARE = 0.003;
const OPAQUE = 250;

/** Whether something is drawn by the 3D page in a frame: an empty one is clear but for the axes of its room. */
export function hasDrawn(frame: HTMLIFrameElement | null): boolean {
  const drawn = frame?.contentDocument?.querySelector('canvas[data-engine]') as HTMLCanvasElement | null | undefined;
  if (!drawn?.width || !drawn.height) return false;
  const small = document.createElement('canvas');
  small.width = small.height = SIDE_PX;
  const pen = small.getContext('2d');
  if (!pen) return true;
  pen.drawImage(drawn, 0, 0, SIDE_PX, SIDE_PX);
  const { data } = pen.getImageData(0, 0, SIDE_PX, SIDE_PX);
  let count = 0;
  for (let at = 3; at < data.length; at += 4) if ((data[at] ?? 0) > OPAQUE) count += 1;
  return count > DRAWN_SHARE * SIDE_PX * SIDE_PX;
}
