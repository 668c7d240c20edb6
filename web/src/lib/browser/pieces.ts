// Pages come in pieces that are fetched when first opened: a piece that does not come is no fault of the page.
import type { PathOf } from '../../api/address';

/** What the browsers say when a piece of the program could not be fetched. */
const NOT_FETCHED = /dynamically imported module|module script failed|loading.*chunk|preload CSS/i;

/** Whether this says that something could not be fetched, and not that the page is wrong. */
export function isNotFetched(error: unknown): boolean {
  return (
    error instanceof Error &&
    (NOT_FETCHED.test(error.message) || (error.name === 'ApiError' && 'status' in error && error.status === 0))
  );
}

/** Whether the service answers now. */
export async function isServiceThere(): Promise<boolean> {
  try {
    return (await fetch('/api/health' satisfies PathOf<'get'>, { cache: 'no-store' })).ok;
  } catch {
    return false;
  }
}
