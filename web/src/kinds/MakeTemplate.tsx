import { Button } from '@mantine/core';
import { IconArrowRight } from '@tabler/icons-react';
import { Link } from 'react-router';
import type { SessionDetail } from '../api/types';
import { t } from '../i18n';

/** To the page that makes a template from what was recorded, for those who treat the patient. */
export function MakeTemplate({ session }: { session: SessionDetail }) {
  if (!session.may_treat) return null;
  const exercise = session.exercise_id ? `&exercise=${session.exercise_id}` : '';
  return (
    <Button
      component={Link}
      variant="default"
      to={`/templates/record?session=${session.id}&patient=${session.patient_id}${exercise}`}
      rightSection={<IconArrowRight size={18} aria-hidden />}
    >
      {t('template.makeFromThis')}
    </Button>
  );
}
