import { Button } from '@mantine/core';
import { IconFileText } from '@tabler/icons-react';
import { Link } from 'react-router';
import type { SessionDetail } from '../../api/types';
import { t } from '../../i18n';
import { MakeTemplate } from '../MakeTemplate';

/** Make a template from what was recorded, or read its report. */
export function SessionActions({ session }: { session: SessionDetail }) {
  return (
    <>
      <MakeTemplate session={session} />
      <Button
        component={Link}
        variant="default"
        to={`/sessions/${session.id}/report`}
        leftSection={<IconFileText size={18} aria-hidden />}
      >
        {t('report.open')}
      </Button>
    </>
  );
}
