// An upload that meets an ended sign-in: asked for over the page, then the form goes out again, with the token of the new one.
import { afterEach, expect, it, vi } from 'vitest';
import { setCsrfToken, upload } from '../../../src/api/client';
import { showSignInAgain } from '../../../src/api/signInAgain';

afterEach(() => {
  vi.unstubAllGlobals();
  setCsrfToken('');
});

const ENDED = { code: 'sign_in_required', message: 'Sign in.', details: {} };

/** A service that answers each attempt in turn (null: it closes the line); returns the tokens that were sent. */
function service(answers: ([number, unknown] | null)[]): string[] {
  const tokens: string[] = [];
  vi.stubGlobal(
    'XMLHttpRequest',
    class {
      upload = {};
      status = 0;
      responseText = '';
      onload: () => void = () => undefined;
      onerror: () => void = () => undefined;
      open() {}
      setRequestHeader(_: string, value: string) {
        tokens.push(value);
      }
      send() {
        const answer = answers.shift();
        if (!answer) return this.onerror();
        this.status = answer[0];
        this.responseText = JSON.stringify(answer[1]);
        this.onload();
      }
    },
  );
  return tokens;
}

/** Somebody who answers the question of the sign-in; returns how often it was asked. */
function person(signsIn: boolean) {
  const asked = { times: 0 };
  const end = showSignInAgain(
    (done) => {
      asked.times += 1;
      if (signsIn) setCsrfToken('new');
      // A person takes a moment.
      setTimeout(() => done(signsIn));
    },
    () => undefined,
  );
  return { asked, end };
}

const send = () => upload('/api/uploads', {}, new FormData(), () => undefined);

it('asks for the sign-in and sends the form again', async () => {
  setCsrfToken('old');
  const tokens = service([
    [401, ENDED],
    [202, { id: 'j' }],
  ]);
  const { asked, end } = person(true);
  expect(await send()).toEqual({ id: 'j' });
  expect(tokens).toEqual(['old', 'new']);
  expect(asked.times).toBe(1);
  end();
});

it('asks too where the service closed the line before its refusal was heard', async () => {
  vi.stubGlobal('fetch', () => Promise.resolve(Response.json(ENDED, { status: 401 })));
  service([null, [202, { id: 'j' }]]);
  const { end } = person(true);
  expect(await send()).toEqual({ id: 'j' });
  end();
});

it('does not ask where only the network failed, and stays refused where nobody signs in', async () => {
  vi.stubGlobal('fetch', () => Promise.resolve(Response.json({ account_id: 'a' })));
  const { asked, end } = person(false);
  service([null]);
  await expect(send()).rejects.toMatchObject({ code: 'offline' });
  expect(asked.times).toBe(0);
  service([[401, ENDED]]);
  await expect(send()).rejects.toMatchObject({ status: 401 });
  expect(asked.times).toBe(1);
  end();
});
