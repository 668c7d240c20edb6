// One way to the service: JSON in, JSON out with its words in the reader's language, errors as `ApiError`.
import { t } from '../i18n';
import { sentencesReady } from '../i18n/languages';
import { inOurWords } from '../i18n/sentence';
import { idleSeconds } from '../lib/browser/idle';
import {
  address,
  addressOf,
  type Address,
  type Answer,
  type BesideForm,
  type Given,
  type Method,
  type PathOf,
} from './address';
import { anotherSignedIn, signInAgain } from './signInAgain';

/** What the service refused, in words that say what to do. */
export class ApiError extends Error {
  override readonly name = 'ApiError';
  constructor(
    readonly status: number,
    readonly code: string,
    message: string,
    readonly details: Record<string, unknown> = {},
  ) {
    super(message);
  }
}

function idleHeader(): Record<string, string> {
  return { 'X-Idle-Seconds': String(idleSeconds()) };
}

let csrfToken = '';
let account = '';

/** Remember the token of the signed-in session, which goes out with every change, and whose session it is. */
export function setCsrfToken(token: string, ofAccount = ''): void {
  csrfToken = token;
  account = ofAccount;
}

/** A change with the token of an earlier sign-in: another tab of this browser has signed in since. */
function isTokenOld(error: ApiError): boolean {
  return error.status === 403 && error.details.header === 'X-CSRF-Token';
}

/** Whether the same account has signed in elsewhere, whose token is then taken; to another one the page is not left. */
async function renewToken(): Promise<boolean> {
  if (account === '') return false;
  const me = await api.get(address('/api/me'));
  if (me.account_id !== account) {
    anotherSignedIn(me.account_id);
    return false;
  }
  csrfToken = me.csrf_token;
  return true;
}

async function errorOf(response: Response): Promise<ApiError> {
  const fallback = t('link.answered', { status: response.status });
  try {
    const body = await heard<{ code?: string; message?: string; details?: Record<string, unknown> }>(
      await response.text(),
    );
    return new ApiError(response.status, body.code ?? 'unknown', body.message ?? fallback, body.details ?? {});
  } catch {
    return new ApiError(response.status, 'unknown', fallback);
  }
}

/** How a request goes on when its sign-in is not there any more. */
interface Manner {
  /** A person pressed something: the sign-in is asked for over the page. */
  isByHand?: boolean;
  /** Sent again with a new token: a second refusal stands. */
  isAgain?: boolean;
}

async function send(path: string, init: RequestInit, manner: Manner = {}): Promise<Response> {
  let response: Response;
  try {
    response = await fetch(path, {
      credentials: 'same-origin',
      ...init,
      headers: {
        ...idleHeader(),
        // Of the sign-in that holds when it is sent: after signing in again it is another one.
        ...(init.method ? { 'X-CSRF-Token': csrfToken } : {}),
        ...(init.body ? { 'Content-Type': 'application/json' } : {}),
      },
    });
  } catch (error) {
    if (error instanceof DOMException && error.name === 'AbortError') throw error;
    throw new ApiError(0, 'offline', t('link.unreachable'));
  }
  if (response.ok) return response;
  const error = await errorOf(response);
  if (isSignInNeeded(error, path) && (await signInAgain(manner.isByHand === true))) return send(path, init, manner);
  if (isTokenOld(error) && !manner.isAgain && (await renewToken()))
    return send(path, init, { ...manner, isAgain: true });
  throw error;
}

function isSignInNeeded(error: ApiError, path: string): boolean {
  return error.status === 401 && error.code === 'sign_in_required' && !/^\/api\/sign-(in|out)$/.test(path);
}

/** An answer with its sentences in the reader's language; their words are fetched when the first of them arrives. */
async function heard<T>(text: string): Promise<T> {
  if (/"(sentences":{"|label":"|main_measure":"|is_offline":|endings":)/.test(text)) await sentencesReady();
  return inOurWords(JSON.parse(text) as T);
}

async function json<T>(response: Response): Promise<T> {
  if (response.status === 204) return undefined as T;
  const text = await response.text();
  return (text ? await heard<T>(text) : undefined) as T;
}

function change<M extends Method>(method: M, manner?: Manner) {
  return async <P extends PathOf<M>>(path: P, ...[asked, signal]: Given<M, P>): Promise<Answer<M, P>> => {
    const body = asked?.body === undefined ? undefined : JSON.stringify(asked.body);
    return json(await send(addressOf(path, asked), { method: method.toUpperCase(), signal, body }, manner));
  };
}

type RowOf<T> = T extends readonly (infer Row)[] ? Row : never;
/** One page of a list, and the address of the next while there is more. */
export interface ListPage<T> {
  rows: RowOf<T>[];
  next: Address<T> | null;
}

async function page<T>(at: Address<T>, signal?: AbortSignal): Promise<ListPage<T>> {
  const response = await send(at, { signal });
  const next = /<([^>]*)>;\s*rel="next"/.exec(response.headers.get('Link') ?? '')?.[1];
  return { rows: await json(response), next: (next as Address<T> | undefined) ?? null };
}

/** A whole list, page after page, for what needs every row: choices in a form, a comparison over all. */
async function all<T>(first: Address<T>, signal?: AbortSignal): Promise<RowOf<T>[]> {
  const found: RowOf<T>[] = [];
  for (let at: Address<T> | null = first; at !== null;) {
    const { rows, next }: ListPage<T> = await page(at, signal);
    found.push(...rows);
    at = next;
  }
  return found;
}

/** Questions, and changes that a page makes by itself. */
export const api = {
  get: async <T>(at: Address<T>, signal?: AbortSignal): Promise<T> => json(await send(at, { signal })),
  page,
  all,
  binary: async (at: Address<unknown>, signal?: AbortSignal): Promise<ArrayBuffer> =>
    (await send(at, { signal })).arrayBuffer(),
  /** An answer whose body is read piece by piece. */
  stream: async (at: Address<unknown>, signal?: AbortSignal): Promise<Response> => send(at, { signal }),
  post: change('post'),
};

const BY_HAND = { isByHand: true };
/** Changes that a person asked for: where the sign-in has ended, it is asked for over the page, and then they go on. */
export const byHand = {
  post: change('post', BY_HAND),
  put: change('put', BY_HAND),
  patch: change('patch', BY_HAND),
  delete: change('delete', BY_HAND),
};

/** Whether the sign-in has ended: a service that refuses a long file early may close the line before its answer is heard. */
async function hasSignInEnded(): Promise<boolean> {
  try {
    const response = await fetch(address('/api/me'), { credentials: 'same-origin', headers: idleHeader() });
    return !response.ok && isSignInNeeded(await errorOf(response), '/api/me');
  } catch {
    return false;
  }
}

/**
 * Upload a form with progress from 0 to 1; fetch cannot tell how much was sent. A person asked for it: where the sign-in has
 * ended, it is asked for over the page, and then the form is sent again.
 */
export async function upload<P extends PathOf<'post'>>(
  path: P,
  names: BesideForm<P>,
  form: FormData,
  onProgress: (share: number) => void,
  signal?: AbortSignal,
): Promise<Answer<'post', P>> {
  const at = addressOf(path, names);
  for (let isRenewed = false; ;) {
    try {
      return await uploadOnce(at, form, onProgress, signal);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      if (isSignInNeeded(error, at) || (error.code === 'offline' && (await hasSignInEnded()))) {
        if (!(await signInAgain(true))) throw error;
      } else if (isTokenOld(error) && !isRenewed && (await renewToken())) isRenewed = true;
      else throw error;
      onProgress(0);
    }
  }
}

function uploadOnce<T>(
  path: string,
  form: FormData,
  onProgress: (share: number) => void,
  signal?: AbortSignal,
): Promise<T> {
  return new Promise<T>((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open('POST', path);
    request.setRequestHeader('X-CSRF-Token', csrfToken);
    request.upload.onprogress = (event) => {
      if (event.lengthComputable) onProgress(event.loaded / event.total);
    };
    request.onerror = () => reject(new ApiError(0, 'offline', t('link.interrupted')));
    request.onabort = () => reject(new DOMException('Aborted', 'AbortError'));
    request.onload = async () => {
      if (request.status >= 200 && request.status < 300) resolve(await heard<T>(request.responseText));
      else reject(await errorOf(new Response(request.responseText, { status: request.status })));
    };
    signal?.addEventListener('abort', () => request.abort());
    request.send(form);
  });
}

/** Address of a socket of this service. */
export function socketUrl(path: string): string {
  const scheme = window.location.protocol === 'https:' ? 'wss:' : 'ws:';
  return `${scheme}//${window.location.host}${path}`;
}
