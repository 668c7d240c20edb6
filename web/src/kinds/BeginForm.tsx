// The questions of a kind for a new session, and the buttons.
import { Button, Group, Switch } from '@mantine/core';
import { useState, type FormEvent, type ReactNode } from 'react';
import { useNavigate } from 'react-router';
import { useNewSession } from '../api/changes';
import type { SessionIn } from '../api/types';
import { RadioCards } from '../components/forms/Choice';
import type { Unsaved } from '../components/forms/useUnsaved';
import { Problem } from '../components/Feedback';
import { t } from '../i18n';
import type { BeginProps } from './kind';
import { kindOf } from '.';

interface Props extends BeginProps {
  children: ReactNode;
  /** What this kind declares, over what all declare; null while something is lacking. */
  declared: Omit<SessionIn, 'patient_id' | 'pipeline'> | null;
  /** Opens the session, where that takes more than declaring it; then it also releases what is unsaved. */
  create?: ReturnType<typeof useNewSession>;
  /** Shown above the buttons. */
  note?: ReactNode;
  /** Where more is chosen than a click repeats: asked for before leaving, and offered on coming back. */
  unsaved?: Unsaved;
}

export function BeginForm(props: Props) {
  const navigate = useNavigate();
  const plain = useNewSession(props.unsaved?.release);
  const { patient, pipeline, declared, create = plain, unsaved } = props;
  const submit = (event: FormEvent) => {
    event.preventDefault();
    if (!declared) return;
    create.mutate(
      { patient_id: patient.id, pipeline, ...declared },
      { onSuccess: ({ id }) => void navigate(`/sessions/${id}/live`) },
    );
  };
  return (
    <form className="stack" onSubmit={submit}>
      {unsaved?.guard}
      {create.error && <Problem error={create.error} />}
      {props.children}
      {props.note}
      <Group justify="flex-end">
        <Button
          variant="default"
          onClick={() => {
            unsaved?.release();
            void navigate(`/patients/${patient.id}`);
          }}
        >
          {t('action.cancel')}
        </Button>
        <Button type="submit" disabled={declared === null} loading={create.isPending}>
          {t('newSession.go')}
        </Button>
      </Group>
    </form>
  );
}

/** For kinds that ask only which of a few sets of sensors is worn. */
export function BeginWorn(props: BeginProps) {
  const { pipeline, exercise, purpose } = props;
  const worn = kindOf({ pipeline }).begin?.worn ?? [];
  const [chosen, setChosen] = useState('0');
  return (
    <BeginForm
      {...props}
      declared={{ ...exercise, purpose, placements: [...(worn[Number(chosen)]?.placements ?? [])] }}
    >
      <RadioCards
        legend={t('newSession.worn')}
        value={chosen}
        onChange={setChosen}
        options={worn.map(({ title }, index) => ({ value: String(index), title: title() }))}
      />
    </BeginForm>
  );
}

interface YesNoProps {
  label: string;
  description: string;
  value: boolean;
  onChange: (value: boolean) => void;
}

export function YesNo({ onChange, value, ...words }: YesNoProps) {
  return <Switch {...words} checked={value} onChange={(event) => onChange(event.currentTarget.checked)} />;
}
