import { Button, Group, Modal } from '@mantine/core';
import { useDisclosure } from '@mantine/hooks';
import { t } from '../../i18n';

/** A small button whose deed cannot be undone: it asks first and says what will happen. */
export function Confirm({
  label,
  accessibleLabel,
  title,
  text,
  confirm,
  onConfirm,
}: {
  label: string;
  accessibleLabel?: string;
  title: string;
  text: string;
  confirm: string;
  onConfirm: () => void;
}) {
  const [isOpen, dialog] = useDisclosure(false);
  return (
    <>
      <Button variant="subtle" color="gray" size="compact-md" aria-label={accessibleLabel} onClick={dialog.open}>
        {label}
      </Button>
      <Modal
        opened={isOpen}
        onClose={dialog.close}
        title={title}
        closeButtonProps={{ 'aria-label': t('action.close') }}
      >
        <p>{text}</p>
        <Group justify="flex-end" mt="lg">
          <Button variant="default" onClick={dialog.close} data-autofocus>
            {t('action.cancel')}
          </Button>
          <Button
            color="red.8"
            onClick={() => {
              dialog.close();
              onConfirm();
            }}
          >
            {confirm}
          </Button>
        </Group>
      </Modal>
    </>
  );
}
