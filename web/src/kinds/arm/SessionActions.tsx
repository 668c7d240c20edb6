import { Button } from '@mantine/core';
import { IconArrowRight, IconFileText } from '@tabler/icons-react';
import { Link } from 'react-router';
import type { SessionDetail } from '../../api/types';
import { t } from '../../i18n';

/** Make a template from what was recorded, or read its report. */
export function SessionActions({ session }: { session: SessionDetail }) {
  const exercise = session.exercise_id ? `&exercise=${session.exercise_id}` : '';
  return (
    <>
      {session.may_treat && (
        <Button
          component={Link}
          variant="default"
          to={`/templates/record?session=${session.id}&patient=${session.patient_id}${exercise}`}
          rightSection={<IconArrowRight size={18} aria-hidden />}
        >
          {t('template.makeFromThis')}
        </Button>
      )}
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
