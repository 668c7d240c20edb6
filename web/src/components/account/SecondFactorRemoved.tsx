import { Button, Group } from '@mantine/core';
import { Link } from 'react-router';
import { useNoteSecondFactor } from '../../api/changes';
import { t } from '../../i18n';
import { date } from '../../lib/format';
import { Notice, Problem } from '../Feedback';

/** Tells who signs in that an administrator turned their two-step sign-in off; until they say that they have read it. */
export function SecondFactorRemoved({ at }: { at: string }) {
  const note = useNoteSecondFactor();
  return (
    <div className="page page-notice">
      <Notice>
        <p>{t('second.removed', { date: date(at) })}</p>
        {note.error && <Problem error={note.error} />}
        <Group gap="md" mt="xs">
          <Button component={Link} to="/account" size="sm">
            {t('second.setUpAgain')}
          </Button>
          <Button size="sm" variant="default" loading={note.isPending} onClick={() => note.mutate(undefined)}>
            {t('second.understood')}
          </Button>
        </Group>
      </Notice>
    </div>
  );
}
