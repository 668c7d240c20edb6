import { Button, Group, Modal, NumberInput, TextInput } from '@mantine/core';
import { useDisclosure } from '@mantine/hooks';
import { IconKey, IconPlus } from '@tabler/icons-react';
import { useState, type FormEvent } from 'react';
import { useAddDeviceToken, usePairingCode, useRevokeDeviceToken } from '../../api/changes';
import { useDeviceTokens } from '../../api/queries';
import type { DeviceToken, Patient } from '../../api/types';
import { Confirm } from '../../components/forms/Confirm';
import { CopyBox } from '../../components/CopyBox';
import { QueryBoundary, Notice, Problem } from '../../components/Feedback';
import { Pairing } from '../../components/account/Pairing';
import { t } from '../../i18n';
import { date } from '../../lib/format';

function NewToken({ patient, onDone }: { patient: Patient; onDone: () => void }) {
  const add = useAddDeviceToken(patient.id);
  const pairing = usePairingCode(patient.id);
  const [label, setLabel] = useState('');
  const [days, setDays] = useState(90);
  if (pairing.data) return <Pairing made={pairing.data} onDone={onDone} />;
  if (add.data?.token) {
    return (
      <div className="stack">
        <Notice icon={<IconKey size={22} aria-hidden />}>
          <p>{t('device.once')}</p>
        </Notice>
        <CopyBox label={t('device.token')} text={add.data.token} />
        <Group justify="flex-end">
          <Button onClick={onDone}>{t('device.copied')}</Button>
        </Group>
      </div>
    );
  }
  const submit = (event: FormEvent) => {
    event.preventDefault();
    pairing.mutate({ label: label.trim(), days });
  };
  const error = pairing.error ?? add.error;
  return (
    <form className="stack" onSubmit={submit}>
      {error && <Problem error={error} />}
      <TextInput
        label={t('device.label')}
        description={t('device.labelHelp')}
        required
        withAsterisk={false}
        maxLength={100}
        value={label}
        onChange={(event) => setLabel(event.currentTarget.value)}
        data-autofocus
      />
      <NumberInput
        label={t('device.days')}
        min={1}
        max={366}
        value={days}
        onChange={(value) => setDays(Number(value) || 1)}
        maw={220}
      />
      <Group justify="flex-end">
        <Button variant="default" onClick={onDone}>
          {t('action.cancel')}
        </Button>
        <Button
          variant="subtle"
          loading={add.isPending}
          disabled={!label.trim()}
          onClick={() => add.mutate({ label: label.trim(), days })}
        >
          {t('device.makeToken')}
        </Button>
        <Button type="submit" loading={pairing.isPending}>
          {t('device.make')}
        </Button>
      </Group>
    </form>
  );
}

function Line({ token, patient }: { token: DeviceToken; patient: Patient }) {
  const revoke = useRevokeDeviceToken(patient.id);
  return (
    <li>
      <div className="line-head">
        <span className="strong">{token.label}</span>
        <Confirm
          label={t('device.revoke')}
          accessibleLabel={t('device.revokeNamed', { name: token.label })}
          title={t('device.revokeTitle', { name: token.label })}
          text={t('device.revokeText')}
          confirm={t('device.revoke')}
          onConfirm={() => revoke.mutate(token.id)}
        />
      </div>
      <div className="muted small">{t('device.until', { date: date(token.expires_at) })}</div>
      {revoke.error && <Problem error={revoke.error} />}
    </li>
  );
}

export function DevicePanel({ patient }: { patient: Patient }) {
  const mayManage = patient.may_manage && patient.archived_at === null;
  const tokens = useDeviceTokens(patient.id, mayManage);
  const [isOpen, dialog] = useDisclosure(false);
  if (!mayManage) return null;
  // A gateway may have used its code meanwhile.
  const done = () => {
    dialog.close();
    void tokens.refetch();
  };
  return (
    <section className="card" aria-labelledby="devices">
      <div className="card-head">
        <h2 id="devices">{t('device.title')}</h2>
        <Button
          className="end"
          size="sm"
          variant="default"
          leftSection={<IconPlus size={17} aria-hidden />}
          onClick={dialog.open}
        >
          {t('device.add')}
        </Button>
      </div>
      <QueryBoundary of={tokens} lines={2}>
        {(list) => {
          const valid = list.filter((one) => !one.revoked_at);
          return valid.length === 0 ? (
            <p className="muted">{t('device.none')}</p>
          ) : (
            <ul className="plain-list lines">
              {valid.map((one) => (
                <Line key={one.id} token={one} patient={patient} />
              ))}
            </ul>
          );
        }}
      </QueryBoundary>
      <Modal
        opened={isOpen}
        onClose={done}
        title={t('device.dialogTitle')}
        closeButtonProps={{ 'aria-label': t('action.close') }}
      >
        {isOpen && <NewToken patient={patient} onDone={done} />}
      </Modal>
    </section>
  );
}
