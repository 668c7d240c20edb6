import { Button } from '@mantine/core';
import { IconShoe } from '@tabler/icons-react';
import { Link } from 'react-router';
import { t } from '../../../i18n';

/** To the strides of an analysed walk. */
export function WalkLink({ sessionId }: { sessionId: string }) {
  return (
    <Button component={Link} to={`/sessions/${sessionId}/gait`} leftSection={<IconShoe size={18} aria-hidden />}>
      {t('walk.open')}
    </Button>
  );
}
