// Said over the live page while packets come and nothing becomes durable.
import { IconDatabaseX } from '@tabler/icons-react';
import type { HealthMessage } from '../../../api/types';
import { t } from '../../../i18n';

export function NotStored({ health }: { health: HealthMessage | null }) {
  if (!health || health.is_being_stored) return null;
  return (
    <div className="banner banner-alert" role="alert">
      <IconDatabaseX size={24} aria-hidden />
      <div>
        <p className="strong">{t('live.notStored')}</p>
        <p>{t('live.notStoredText')}</p>
      </div>
    </div>
  );
}
