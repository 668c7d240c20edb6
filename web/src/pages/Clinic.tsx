// The clinic's accounts: who may sign in, in which role; made, switched off and given a new password by administrators.
import { Button, Group, Modal, PasswordInput, Select, Switch, TextInput } from '@mantine/core';
import { useDisclosure } from '@mantine/hooks';
import { IconKey, IconUserPlus } from '@tabler/icons-react';
import { useState, type FormEvent } from 'react';
import { Link } from 'react-router';
import { useAddAccount, useChangeAccount } from '../api/changes';
import { useAccounts, usePatients } from '../api/queries';
import type { Account, Role } from '../api/types';
import { RadioCards } from '../components/forms/Choice';
import { Confirm } from '../components/forms/Confirm';
import { QueryBoundary, Problem } from '../components/Feedback';
import { Page } from '../components/Page';
import { useSignedIn } from '../components/account/useSignedIn';
import { t } from '../i18n';
import { fullName } from '../lib/people';
import { ClinicCard } from './ClinicCard';
import { SourcesCard } from '../kinds/magnetic/SourcesCard';
import './Clinic.css';

const ROLES: readonly Role[] = ['therapist', 'patient', 'administrator', 'integrator'];
const LEAST_PASSWORD = 10;

function Password({ value, onChange, label }: { value: string; onChange: (value: string) => void; label: string }) {
  return (
    <PasswordInput
      label={label}
      description={t('clinic.passwordHelp', { least: LEAST_PASSWORD })}
      required
      withAsterisk={false}
      minLength={LEAST_PASSWORD}
      maxLength={200}
      autoComplete="new-password"
      value={value}
      onChange={(event) => onChange(event.currentTarget.value)}
      visibilityToggleButtonProps={{ 'aria-label': t('signIn.showPassword'), tabIndex: 0, 'aria-hidden': false }}
    />
  );
}

function NewAccount({ onDone }: { onDone: () => void }) {
  const add = useAddAccount();
  const patients = usePatients();
  const [role, setRole] = useState<Role>('therapist');
  const [name, setName] = useState('');
  const [email, setEmail] = useState('');
  const [password, setPassword] = useState('');
  const [patientId, setPatientId] = useState<string | null>(null);
  const submit = (event: FormEvent) => {
    event.preventDefault();
    add.mutate(
      {
        role,
        display_name: name.trim(),
        email: email.trim(),
        password,
        patient_id: role === 'patient' ? patientId : null,
      },
      { onSuccess: onDone },
    );
  };
  return (
    <form className="stack" onSubmit={submit}>
      {add.error && <Problem error={add.error} />}
      <RadioCards
        legend={t('clinic.role')}
        value={role}
        onChange={setRole}
        options={ROLES.map((one) => ({ value: one, title: t(`role.${one}`), text: t(`clinic.role.${one}`) }))}
      />
      {role === 'patient' && (
        <Select
          label={t('clinic.record')}
          description={t('clinic.recordHelp')}
          searchable
          data={(patients.data ?? []).map((one) => ({ value: one.id, label: fullName(one) }))}
          value={patientId}
          onChange={setPatientId}
        />
      )}
      <TextInput
        label={t('clinic.name')}
        required
        withAsterisk={false}
        maxLength={200}
        value={name}
        onChange={(event) => setName(event.currentTarget.value)}
      />
      <TextInput
        label={t('signIn.email')}
        type="email"
        required
        withAsterisk={false}
        maxLength={254}
        autoComplete="off"
        value={email}
        onChange={(event) => setEmail(event.currentTarget.value)}
      />
      <Password label={t('clinic.firstPassword')} value={password} onChange={setPassword} />
      <Group justify="flex-end">
        <Button variant="default" onClick={onDone}>
          {t('action.cancel')}
        </Button>
        <Button type="submit" loading={add.isPending} disabled={role === 'patient' && !patientId}>
          {t('clinic.make')}
        </Button>
      </Group>
    </form>
  );
}

function NewPassword({ account, onDone }: { account: Account; onDone: () => void }) {
  const change = useChangeAccount();
  const [password, setPassword] = useState('');
  const submit = (event: FormEvent) => {
    event.preventDefault();
    change.mutate({ id: account.id, patch: { password } }, { onSuccess: onDone });
  };
  return (
    <form className="stack" onSubmit={submit}>
      {change.error && <Problem error={change.error} />}
      <p>{t('clinic.resetText', { name: account.display_name })}</p>
      <Password label={t('clinic.newPassword')} value={password} onChange={setPassword} />
      <Group justify="flex-end">
        <Button variant="default" onClick={onDone}>
          {t('action.cancel')}
        </Button>
        <Button type="submit" loading={change.isPending}>
          {t('action.save')}
        </Button>
      </Group>
    </form>
  );
}

function Row({ account, onReset }: { account: Account; onReset: () => void }) {
  const me = useSignedIn();
  const change = useChangeAccount();
  const isOwn = account.id === me.account_id;
  return (
    <li className="account">
      <div>
        <span className="strong">{account.display_name}</span> <span className="tag">{t(`role.${account.role}`)}</span>
        {account.has_second_factor && <span className="tag">{t('clinic.hasSecond')}</span>}
        <div className="muted small account-mail">{account.email}</div>
        {change.error && <Problem error={change.error} />}
      </div>
      {isOwn ? (
        <Link to="/account" className="mine-link">
          {t('account.password')}
        </Link>
      ) : (
        <Group gap="md">
          {account.has_second_factor && (
            <Confirm
              label={t('clinic.removeSecond')}
              accessibleLabel={t('clinic.removeSecondNamed', { name: account.display_name })}
              title={t('clinic.removeSecondTitle', { name: account.display_name })}
              text={t('clinic.removeSecondText')}
              confirm={t('clinic.removeSecond')}
              isGrave
              onConfirm={() => change.mutate({ id: account.id, patch: { remove_second_factor: true } })}
            />
          )}
          <Switch
            label={account.is_active ? t('clinic.active') : t('clinic.inactive')}
            aria-label={t('clinic.mayS', { name: account.display_name })}
            checked={account.is_active}
            disabled={change.isPending}
            onChange={(event) => change.mutate({ id: account.id, patch: { is_active: event.currentTarget.checked } })}
          />
          <Button
            size="sm"
            variant="default"
            leftSection={<IconKey size={17} aria-hidden />}
            aria-label={t('clinic.resetNamed', { name: account.display_name })}
            onClick={onReset}
          >
            {t('clinic.newPassword')}
          </Button>
        </Group>
      )}
    </li>
  );
}

export function ClinicPage() {
  const me = useSignedIn();
  const accounts = useAccounts();
  const [isAdding, adding] = useDisclosure(false);
  const [reset, setReset] = useState<Account | null>(null);
  return (
    <Page
      title={t('clinic.title')}
      lead={me.clinic_name}
      actions={
        me.role === 'administrator' && (
          <Button leftSection={<IconUserPlus size={19} aria-hidden />} onClick={adding.open}>
            {t('clinic.add')}
          </Button>
        )
      }
    >
      <div className="stack">
        <section className="card" aria-labelledby="accounts">
          <div className="card-head">
            <h2 id="accounts">{t('clinic.accounts')}</h2>
          </div>
          <QueryBoundary of={accounts} lines={5}>
            {(list) => (
              <ul className="plain-list lines">
                {list.map((one) => (
                  <Row key={one.id} account={one} onReset={() => setReset(one)} />
                ))}
              </ul>
            )}
          </QueryBoundary>
          <p className="muted small">{t('clinic.devices')}</p>
        </section>
        {me.role === 'administrator' && <ClinicCard />}
        <SourcesCard />
      </div>
      <Modal
        opened={isAdding}
        onClose={adding.close}
        title={t('clinic.add')}
        closeButtonProps={{ 'aria-label': t('action.close') }}
      >
        {isAdding && <NewAccount onDone={adding.close} />}
      </Modal>
      <Modal
        opened={reset !== null}
        onClose={() => setReset(null)}
        title={t('clinic.newPassword')}
        closeButtonProps={{ 'aria-label': t('action.close') }}
      >
        {reset && <NewPassword account={reset} onDone={() => setReset(null)} />}
      </Modal>
    </Page>
  );
}
