import { Button, Group, Modal, Select } from '@mantine/core';
import { useDisclosure } from '@mantine/hooks';
import { IconEye, IconPlus } from '@tabler/icons-react';
import { useState, type FormEvent } from 'react';
import { useGrant, useRevokeGrant } from '../../api/changes';
import { useAccounts, useAudit, useGrants } from '../../api/queries';
import type { Grant, Patient } from '../../api/types';
import { AuditList } from '../../components/account/AuditList';
import { RadioCards } from '../../components/forms/Choice';
import { DateField, isDateOrEmpty } from '../../components/forms/DateField';
import { Confirm } from '../../components/forms/Confirm';
import { QueryBoundary, Problem, ShowMore } from '../../components/Feedback';
import { t } from '../../i18n';
import { date } from '../../lib/format';

function GiveAccess({ patient, onDone }: { patient: Patient; onDone: () => void }) {
  const accounts = useAccounts();
  const grant = useGrant(patient.id);
  const [accountId, setAccountId] = useState<string | null>(null);
  const [level, setLevel] = useState<'read' | 'treat'>('treat');
  const [until, setUntil] = useState('');
  const submit = (event: FormEvent) => {
    event.preventDefault();
    if (!accountId || !isDateOrEmpty(until)) return;
    grant.mutate(
      { account_id: accountId, level, expires_at: until ? new Date(`${until}T23:59:59`).toISOString() : null },
      { onSuccess: onDone },
    );
  };
  return (
    <form className="stack" onSubmit={submit}>
      {grant.error && <Problem error={grant.error} />}
      {accounts.error && <Problem error={accounts.error} />}
      <Select
        label={t('access.colleague')}
        searchable
        openOnFocus={false}
        data={(accounts.data ?? [])
          .filter((one) => one.role === 'therapist' && one.is_active)
          .map((one) => ({ value: one.id, label: one.display_name }))}
        value={accountId}
        onChange={setAccountId}
        data-autofocus
      />
      <RadioCards
        legend={t('access.level')}
        value={level}
        onChange={setLevel}
        options={[
          { value: 'treat', title: t('access.treat'), text: t('access.treatText') },
          { value: 'read', title: t('access.read'), text: t('access.readText') },
        ]}
      />
      <DateField label={t('access.until')} description={t('access.untilHelp')} value={until} onChange={setUntil} />
      <Group justify="flex-end">
        <Button variant="default" onClick={onDone}>
          {t('action.cancel')}
        </Button>
        <Button type="submit" disabled={!accountId} loading={grant.isPending}>
          {t('access.give')}
        </Button>
      </Group>
    </form>
  );
}

function Line({ grant, patient }: { grant: Grant; patient: Patient }) {
  const revoke = useRevokeGrant(patient.id);
  return (
    <li>
      <div className="line-head">
        <span className="strong">{grant.display_name}</span>
        {patient.may_treat && (
          <Confirm
            label={t('access.revoke')}
            accessibleLabel={t('access.revokeNamed', { name: grant.display_name })}
            title={t('access.revokeTitle', { name: grant.display_name })}
            text={t('access.revokeText')}
            confirm={t('access.revoke')}
            onConfirm={() => revoke.mutate(grant.id)}
          />
        )}
      </div>
      <div className="muted small">
        {grant.level === 'treat' ? t('access.treat') : t('access.read')}
        {grant.expires_at && ` · ${t('device.until', { date: date(grant.expires_at) })}`}
      </div>
      {revoke.error && <Problem error={revoke.error} />}
    </li>
  );
}

export function AccessPanel({ patient }: { patient: Patient }) {
  const grants = useGrants(patient.id);
  const [isGiving, giving] = useDisclosure(false);
  const [isReading, reading] = useDisclosure(false);
  const audit = useAudit(patient.id, isReading);
  return (
    <section className="card" aria-labelledby="access">
      <div className="card-head">
        <h2 id="access">{t('access.title')}</h2>
        {patient.may_treat && (
          <Button
            className="end"
            size="sm"
            variant="default"
            leftSection={<IconPlus size={17} aria-hidden />}
            onClick={giving.open}
          >
            {t('access.add')}
          </Button>
        )}
      </div>
      <QueryBoundary of={grants} lines={2}>
        {(list) => (
          <ul className="plain-list lines">
            {list.map((one) => (
              <Line key={one.id} grant={one} patient={patient} />
            ))}
          </ul>
        )}
      </QueryBoundary>
      <Button
        mt={14}
        variant="subtle"
        size="sm"
        px={8}
        ml={-8}
        leftSection={<IconEye size={18} aria-hidden />}
        onClick={reading.open}
      >
        {t('audit.open')}
      </Button>
      <Modal
        opened={isGiving}
        onClose={giving.close}
        title={t('access.dialogTitle')}
        closeButtonProps={{ 'aria-label': t('action.close') }}
      >
        {isGiving && <GiveAccess patient={patient} onDone={giving.close} />}
      </Modal>
      <Modal
        opened={isReading}
        onClose={reading.close}
        size="xl"
        title={t('audit.open')}
        closeButtonProps={{ 'aria-label': t('action.close') }}
      >
        <QueryBoundary of={audit}>{(entries) => <AuditList entries={entries} />}</QueryBoundary>
        <ShowMore of={audit} />
      </Modal>
    </section>
  );
}
