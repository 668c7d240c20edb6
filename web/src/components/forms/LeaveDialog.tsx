// The question of `useUnsaved`, loaded when it is asked for the first time.
import { Button, Group, Modal } from '@mantine/core';
import { t } from '../../i18n';

export default function LeaveDialog({
  onStay,
  onLeave,
  onDiscard,
}: {
  onStay: () => void;
  /** Absent while an older draft is offered, which what was typed now must not replace. */
  onLeave?: () => void;
  onDiscard: () => void;
}) {
  return (
    <Modal opened onClose={onStay} title={t('unsaved.title')} closeButtonProps={{ 'aria-label': t('action.close') }}>
      <p>{t(onLeave ? 'unsaved.text' : 'unsaved.textOffered')}</p>
      <Group justify="flex-end" mt="lg">
        <Button variant="subtle" color="red.8" onClick={onDiscard}>
          {t('unsaved.discardAndLeave')}
        </Button>
        {onLeave && (
          <Button variant="default" onClick={onLeave}>
            {t('unsaved.leave')}
          </Button>
        )}
        <Button onClick={onStay} data-autofocus>
          {t('unsaved.stay')}
        </Button>
      </Group>
    </Modal>
  );
}
