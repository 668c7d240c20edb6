// Which forms on this page hold something that is not saved.

/** One form; released once its content is saved, discarded, or no longer this person's. */
export interface Held {
  isReleased: boolean;
}

const forms = new Set<Held>();

/** Note a form with unsaved content; returns how to end that. */
export function hold(form: Held): () => void {
  forms.add(form);
  return () => void forms.delete(form);
}

export function hasUnsaved(): boolean {
  return [...forms].some((one) => !one.isReleased);
}

/** Nothing on this page is to be asked for or stored any more. */
export function releaseAll(): void {
  for (const one of forms) one.isReleased = true;
  forms.clear();
}
