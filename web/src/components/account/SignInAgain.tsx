// Signing in again over a page whose sign-in has ended: the page stays as it is and cannot be read meanwhile.
import { Button, Group, Modal } from '@mantine/core';
import { useMutation, useQueryClient } from '@tanstack/react-query';
import { useEffect } from 'react';
import { api } from '../../api/client';
import { key } from '../../api/address';
import { acceptMe } from '../../api/queries';
import { anotherSignedIn } from '../../api/signInAgain';
import type { Me, SignInRequest } from '../../api/types';
import { t } from '../../i18n';
import { holdEscape } from '../../lib/browser/escape';
import { Problem } from '../Feedback';
import { isCodeAsked, useSignInFields } from './SignInFields';

export default function SignInAgain({
  me,
  onDone,
}: {
  /** Who was signed in. */
  me: Me;
  /** Called with whether it is the same account again. */
  onDone: (isSame: boolean) => void;
}) {
  const client = useQueryClient();
  const { request, fields, onError } = useSignInFields(me.email);
  const signIn = useMutation({
    mutationFn: (body: SignInRequest) => api.post('/api/sign-in', { body }),
    onSuccess: async (now) => {
      if (now.account_id !== me.account_id) {
        anotherSignedIn(now.account_id);
        return;
      }
      client.setQueryData(key('me'), await acceptMe(now));
      onDone(true);
    },
    onError,
  });
  // A form below that is a dialog too would close and lose what is in it.
  useEffect(holdEscape, []);
  const leave = () => {
    onDone(false);
    client.setQueryData(key('me'), null);
  };
  return (
    <Modal
      opened
      onClose={() => undefined}
      withCloseButton={false}
      closeOnEscape={false}
      closeOnClickOutside={false}
      zIndex={400}
      title={t('signIn.againTitle')}
      overlayProps={{ backgroundOpacity: 0.75, blur: 14 }}
    >
      <form
        className="stack"
        onSubmit={(event) => {
          event.preventDefault();
          // In a dialog of a form, React passes it on to that form too.
          event.stopPropagation();
          signIn.mutate(request);
        }}
      >
        <p>{t('signIn.againText')}</p>
        {signIn.error && !isCodeAsked(signIn.error) && <Problem error={signIn.error} />}
        {fields}
        <Group justify="flex-end">
          <Button variant="default" onClick={leave}>
            {t('signIn.againLeave')}
          </Button>
          <Button type="submit" loading={signIn.isPending}>
            {t('signIn.againGo')}
          </Button>
        </Group>
      </form>
    </Modal>
  );
}
