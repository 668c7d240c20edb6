// Escape, which closes dialogs. While a question is open that it does not answer, it must not close the dialog below either:
// every open dialog listens at the window. This listener comes first because it is there before any dialog is.
const holding = new Set<symbol>();

window.addEventListener(
  'keydown',
  (event) => {
    if (event.key === 'Escape' && holding.size > 0) event.stopImmediatePropagation();
  },
  { capture: true },
);

/** Escape closes nothing until the returned function is called. */
export function holdEscape(): () => void {
  const one = Symbol('Escape');
  holding.add(one);
  return () => void holding.delete(one);
}
