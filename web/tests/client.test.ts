// A path, a parameter, a body and an answer are what the service's schema says, or this file does not compile.
import { expect, it } from 'vitest';
import { address, key, keyOf, ofPatient, ofSession } from '../src/api/address';
import { api, byHand, upload } from '../src/api/client';

it('makes an address from a path and its names, and leaves out what has no value', () => {
  expect(address('/api/patients/{patient_id}', ofPatient('a/b'))).toBe('/api/patients/a%2Fb');
  expect(address('/api/templates', { query: { words: '', exercise_id: null } })).toBe('/api/templates');
  expect(address('/api/templates', { query: { words: 'arm, up', is_retired: true } })).toBe(
    '/api/templates?words=arm%2C%20up&is_retired=true',
  );
  // Half of a character, of one that is being typed.
  expect(address('/api/templates', { query: { words: 'a\uD83D' } })).toBe('/api/templates?words=a%EF%BF%BD');
});

it('takes the pieces of an address as its key, so the key of a patient stands for all that lies below', () => {
  expect(keyOf(address('/api/patients/{patient_id}/grants', ofPatient('p')))).toEqual(key('patients', 'p', 'grants'));
  expect(keyOf(address('/api/patients', { query: { archived: true } }))).toEqual(['patients', 'archived=true']);
});

/** Compiled and never called. Each line that is expected to fail names something that the service does not have. */
export async function compiled() {
  (await api.get(address('/api/me'))).csrf_token satisfies string;
  (await byHand.post('/api/sessions/{session_id}/ticket', { ...ofSession('s'), body: { purpose: 'ingest' } }))
    .ticket satisfies string;
  (await byHand.post('/api/me/second-factor/noted')) satisfies undefined;
  // @ts-expect-error No such path.
  address('/api/mee');
  // @ts-expect-error The path has no such method.
  await byHand.put('/api/patients', { body: { given_name: 'Ada', family_name: 'Berg' } });
  // @ts-expect-error The name in the path is another one.
  address('/api/patients/{patient_id}', { path: { id: 'p' } });
  // @ts-expect-error A parameter that the path needs is absent.
  address('/api/patients/{patient_id}/course', ofPatient('p'));
  // @ts-expect-error No such parameter.
  address('/api/templates', { query: { word: 'arm' } });
  // @ts-expect-error The body is absent.
  await byHand.post('/api/patients');
  // @ts-expect-error No such field in the body.
  await byHand.patch('/api/me', { body: { language: 'de' } });
  // @ts-expect-error No such value of the field.
  await byHand.post('/api/sessions/{session_id}/guidance', { ...ofSession('s'), body: { command: 'halt' } });
  // @ts-expect-error No such field in the answer.
  (await api.get(address('/api/me'))).token satisfies unknown;
  // @ts-expect-error No such field in a row.
  (await api.all(address('/api/accounts')))[0]?.name satisfies unknown;
  // @ts-expect-error A form goes to a path with a name.
  await upload('/api/sessions/{session_id}/markers', {}, new FormData(), () => undefined);
  // @ts-expect-error Nothing is asked at such an address.
  key('patients', 'p', 'grant');
}
