// The question of `useUnsaved`, loaded when it is asked for the first time.
import { Button, Group, Modal } from '@mantine/core';
import { t } from '../../i18n';

export default function LeaveDialog({
  onStay,
  onLeave,
  onDiscard,
}: {
  onStay: () => void;
  onLeave: () => void;
  onDiscard: () => void;
}) {
  return (
    <Modal opened onClose={onStay} title={t('unsaved.title')} closeButtonProps={{ 'aria-label': t('action.close') }}>
      <p>{t('unsaved.text')}</p>
      <Group justify="flex-end" mt="lg">
        <Button variant="subtle" color="red.8" onClick={onDiscard}>
          {t('unsaved.discardAndLeave')}
        </Button>
        <Button variant="default" onClick={onLeave}>
          {t('unsaved.leave')}
        </Button>
        <Button onClick={onStay} data-autofocus>
          {t('unsaved.stay')}
        </Button>
      </Group>
    </Modal>
  );
}
