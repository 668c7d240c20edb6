// Paths, parameters, bodies and answers as the generated types of the service say: a name that changed there fails
// to compile.
// `openapi-fetch` makes the addresses. The client sends them itself, as a `Request` cannot be sent again after signing in.
// `openapi-react-query` is not used: its keys do not nest, and a change names a patient to make all below old.
import {
  createFinalURL,
  createQuerySerializer,
  defaultPathSerializer,
  type Client,
  type ClientPathsWithMethod,
  type RequestBodyOption,
} from 'openapi-fetch';
import type { paths } from './schema';

export type Method = 'get' | 'post' | 'put' | 'patch' | 'delete';
export type PathOf<M extends Method> = ClientPathsWithMethod<Client<paths>, M>;

/** The names in a path and in its query. */
type Names<Operation> = Operation extends { parameters: infer All } ? Pick<All, keyof All & ('path' | 'query')> : never;
/** What one kind of request carries besides its path. */
type Asked<Operation> = Names<Operation> & RequestBodyOption<Operation>;
/** The same as arguments: absent where nothing of it is needed. */
export type Given<M extends Method, P extends PathOf<M>> =
  object extends Asked<paths[P][M]>
    ? [asked?: Asked<paths[P][M]>, signal?: AbortSignal]
    : [asked: Asked<paths[P][M]>, signal?: AbortSignal];

/** What a form carries besides itself. */
export type BesideForm<P extends PathOf<'post'>> = Names<paths[P]['post']>;

type Json<Response> = Response extends { content: { 'application/json': infer Content } } ? Content : undefined;
export type Answer<M extends Method, P extends PathOf<M>> = paths[P][M] extends { responses: infer All }
  ? Json<All[keyof All & (200 | 201 | 202 | 204)]>
  : never;

declare const answers: unique symbol;
/** An address of the service that knows what is answered there. */
export type Address<T> = string & { readonly [answers]: T };

const serialized = createQuerySerializer();
/** Half of a character, as a text field holds it while one is typed, has no place in an address. */
const whole = (value: unknown) => (typeof value === 'string' ? value.replace(/\p{Surrogate}/gu, '\uFFFD') : value);

/** The address of a path with its parameters; those without a value are left out. */
export function addressOf(path: string, asked: object = {}): string {
  const { path: names, query = {} } = asked as { path?: Record<string, unknown>; query?: object };
  return createFinalURL(path, {
    baseUrl: '',
    params: {
      path: names,
      query: Object.fromEntries(
        Object.entries(query).flatMap(([name, value]) => (value === '' ? [] : [[name, whole(value)]])),
      ),
    },
    querySerializer: serialized,
    pathSerializer: defaultPathSerializer,
  });
}

/** The address of a question. */
export const address = <P extends PathOf<'get'>>(path: P, ...[asked]: Given<'get', P>) =>
  addressOf(path, asked) as Address<Answer<'get', P>>;

/** The names in a path below a patient, and below a session. */
export const ofPatient = (patient_id: string) => ({ path: { patient_id } });
export const ofSession = (session_id: string) => ({ path: { session_id } });

type Piece<Text> = Text extends `{${string}}` ? string : Text;
type Pieces<Text> = Text extends `${infer First}/${infer Rest}` ? [Piece<First>, ...Pieces<Rest>] : [Piece<Text>];
type Starts<All> = All extends [...infer Before, unknown] ? All | Starts<Before> : never;
/** An address in pieces, or its first pieces, which stand for everything below. */
export type Key = { [P in keyof paths]: P extends `/api/${infer Rest}` ? Starts<Pieces<Rest>> : never }[keyof paths];

/** The key of what was answered at an address. */
export const keyOf = (at: string): readonly string[] => at.replace('/api/', '').split(/[/?]/);
/** The key of an address by its pieces. */
export const key = (...pieces: Key): Key => pieces;
