// Whether the service answers over HTTP, asked where its sockets are silent.
import type { PathOf } from '../api/address';

/** The service says something once a second: two words missing, it is out of reach. */
export const REACH_S = 2.5;
const PATIENCE_MS = 2000;

/** Whether the service itself answers now: an error page of a proxy, or a sign-in page of a network, is no answer. */
export async function serviceAnswers(): Promise<boolean> {
  try {
    const answer = await fetch('/api/health' satisfies PathOf<'get'>, {
      cache: 'no-store',
      signal: AbortSignal.timeout(PATIENCE_MS),
    });
    return answer.ok && ((await answer.json()) as { status?: string }).status === 'ok';
  } catch {
    return false;
  }
}
