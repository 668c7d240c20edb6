import { Button } from '@mantine/core';
import { IconMapOff } from '@tabler/icons-react';
import { Link } from 'react-router';
import { Empty } from '../components/Feedback';
import { Page } from '../components/Page';
import { t } from '../i18n';

export function NotFoundPage() {
  return (
    <Page title={t('notFound.title')} narrow>
      <div className="card">
        <Empty
          icon={<IconMapOff size={44} aria-hidden />}
          title={t('notFound.heading')}
          action={
            <Button component={Link} to="/">
              {t('notFound.back')}
            </Button>
          }
        >
          {t('notFound.text')}
        </Empty>
      </div>
    </Page>
  );
}
