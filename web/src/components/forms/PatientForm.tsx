import { Button, Checkbox, Group, SimpleGrid, Textarea, TextInput } from '@mantine/core';
import { useState, type FormEvent } from 'react';
import { Link } from 'react-router';
import { ApiError } from '../../api/client';
import type { BodyDimensions, Patient, PatientIn, Side } from '../../api/types';
import { t } from '../../i18n';
import { bodyLength } from '../../lib/format';
import { isSame } from '../../lib/editing/merge';
import { birthError } from '../../lib/dates';
import { readLengthCm } from '../../lib/lengths';
import { DateField, isDateOrEmpty } from './DateField';
import { SideChoice } from './Choice';
import { Problem } from '../Feedback';
import { useUnsaved } from './useUnsaved';

const LENGTHS = ['stature_m', 'upper_arm_m', 'forearm_m', 'hand_m', 'shoulder_width_m', 'trunk_m'] as const;
type Length = (typeof LENGTHS)[number];
/** What the service accepts, in cm; the message names the range before anything is sent. */
const RANGES_CM: Record<Length, readonly [number, number]> = {
  stature_m: [51, 259],
  upper_arm_m: [11, 59],
  forearm_m: [11, 49],
  hand_m: [6, 34],
  shoulder_width_m: [11, 69],
  trunk_m: [21, 89],
};

export interface PatientFormProps {
  patient?: Patient;
  isSaving: boolean;
  error: unknown;
  /** `saved` is called before the form is left: what was typed is then no longer held on this device. */
  onSave: (input: PatientIn, saved: () => void) => void;
  onCancel: () => void;
}

/** What is typed, as it is typed. */
interface Texts {
  given: string;
  family: string;
  birth: string;
  side: Side | '';
  notes: string;
  lengths: Record<Length, string>;
}

function textsOf(patient: Patient | undefined): Texts {
  const lengths = Object.fromEntries(
    LENGTHS.map((name) => {
      const metres = patient?.body_dimensions?.[name];
      return [name, metres === null || metres === undefined ? '' : String(Math.round(metres * 1000) / 10)];
    }),
  ) as Record<Length, string>;
  return {
    given: patient?.given_name ?? '',
    family: patient?.family_name ?? '',
    birth: patient?.birth_date ?? '',
    side: patient?.affected_side ?? '',
    notes: patient?.notes ?? '',
    lengths,
  };
}

/** A new patient or a change: names, side, and lengths in cm as a tape shows them; of a new one also the consent to treatment. */
export function PatientForm({ patient, isSaving, error, onSave, onCancel }: PatientFormProps) {
  const [start] = useState(() => textsOf(patient));
  const [texts, setTexts] = useState(start);
  const set = (some: Partial<Texts>) => setTexts((now) => ({ ...now, ...some }));
  const { given, family, birth, side, notes, lengths } = texts;
  const [agrees, setAgrees] = useState(false);
  // The consent is no part of it: it is said anew.
  const { guard, release } = useUnsaved({
    object: `patient:${patient?.id ?? 'new'}`,
    value: texts,
    isChanged: !isSame(texts, start),
    onRestore: setTexts,
  });
  const outOfRange = (name: Length) => {
    const value = readLengthCm(lengths[name]);
    const [low, high] = RANGES_CM[name];
    return value === null || (value >= low && value <= high) ? null : t('patient.lengthRange', { low, high });
  };
  const understood = (name: Length) => {
    const cm = readLengthCm(lengths[name]);
    return cm === null || outOfRange(name) ? undefined : bodyLength(cm / 100);
  };
  const [hasTried, setTried] = useState(false);
  const [isAnother, setAnother] = useState(false);
  const hasName = given.trim() !== '' || family.trim() !== '';
  const birthProblem = birthError(birth);
  const twin = error instanceof ApiError && error.details.field === 'is_another_person' ? error.details : null;
  const submit = (event: FormEvent) => {
    event.preventDefault();
    setTried(true);
    if (LENGTHS.some(outOfRange) || !isDateOrEmpty(birth) || birthProblem || !hasName) return;
    const body: BodyDimensions = {};
    for (const name of LENGTHS) {
      const cm = readLengthCm(lengths[name]);
      body[name] = cm === null ? null : cm / 100;
    }
    const input: PatientIn = {
      given_name: given.trim(),
      family_name: family.trim(),
      birth_date: birth || null,
      affected_side: side || null,
      notes,
      body_dimensions: body,
      ...(patient ? {} : { agrees_to_treatment: agrees, is_another_person: isAnother }),
    };
    onSave(input, release);
  };
  return (
    <form className="stack" onSubmit={submit}>
      {guard}
      {error ? <Problem error={error} /> : null}
      {twin && (
        <Group>
          <Link to={`/patients/${String(twin.patient_id)}`}>{t('patient.openTwin')}</Link>
          <Checkbox
            label={t('patient.isAnother')}
            checked={isAnother}
            onChange={(event) => setAnother(event.currentTarget.checked)}
          />
        </Group>
      )}
      <SimpleGrid cols={{ base: 1, xs: 2 }}>
        <TextInput
          label={t('patient.givenName')}
          error={hasTried && !hasName ? t('patient.oneName') : null}
          maxLength={100}
          value={given}
          onChange={(event) => set({ given: event.currentTarget.value })}
          data-autofocus
        />
        <TextInput
          label={t('patient.familyName')}
          maxLength={100}
          value={family}
          onChange={(event) => set({ family: event.currentTarget.value })}
        />
      </SimpleGrid>
      <DateField
        label={t('patient.birthDate')}
        value={birth}
        onChange={(value) => set({ birth: value })}
        problem={birthProblem}
      />
      <SideChoice
        legend={t('patient.affectedSide')}
        value={side}
        onChange={(value) => set({ side: value })}
        allowNone
      />
      <fieldset className="fieldset">
        <legend>{t('patient.dimensions')}</legend>
        <p className="muted small">{t('patient.dimensionsHelp')}</p>
        <SimpleGrid cols={{ base: 2, sm: 3 }}>
          {LENGTHS.map((name) => (
            <TextInput
              key={name}
              label={t(`length.${name}`)}
              inputMode="decimal"
              autoComplete="off"
              value={lengths[name]}
              error={outOfRange(name)}
              description={understood(name)}
              inputWrapperOrder={['label', 'input', 'description', 'error']}
              onChange={(event) => set({ lengths: { ...lengths, [name]: event.currentTarget.value } })}
            />
          ))}
        </SimpleGrid>
      </fieldset>
      <Textarea
        label={t('patient.notes')}
        autosize
        minRows={3}
        maxLength={4000}
        value={notes}
        onChange={(event) => set({ notes: event.currentTarget.value })}
      />
      {!patient && (
        <Checkbox
          size="md"
          label={t('patient.agrees')}
          description={t('patient.agreesHelp')}
          checked={agrees}
          onChange={(event) => setAgrees(event.currentTarget.checked)}
        />
      )}
      <Group justify="flex-end">
        <Button
          variant="default"
          onClick={() => {
            release();
            onCancel();
          }}
        >
          {t('action.cancel')}
        </Button>
        <Button type="submit" loading={isSaving}>
          {t('action.save')}
        </Button>
      </Group>
    </form>
  );
}
