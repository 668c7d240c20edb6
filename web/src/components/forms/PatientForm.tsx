import { Button, Checkbox, Group, SimpleGrid, Textarea, TextInput } from '@mantine/core';
import { useState, type FormEvent } from 'react';
import { Link } from 'react-router';
import { ApiError } from '../../api/client';
import { useAddPatient, useEditPatient } from '../../api/changes';
import type { BodyDimensions, Patient, PatientIn, PatientPatch, Side } from '../../api/types';
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
  onSaved: (patient: Patient) => void;
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

/** What somebody typed, on top of what stands now: fields that were not touched are not brought back. */
function typedOver(now: Texts, typed: Texts, before: Texts): Texts {
  const over = <T extends object>(at: T, mine: T, old: T): T => {
    const touched = Object.entries(mine).filter(([name, value]) => !isSame(value, old[name as keyof T]));
    return { ...at, ...Object.fromEntries(touched) };
  };
  return { ...over(now, typed, before), lengths: over(now.lengths, typed.lengths, before.lengths) };
}

/** All that the form says, as the service takes it; lengths that were not touched are those of the patient. */
function inputOf(texts: Texts, start: Texts, patient: Patient | undefined): PatientIn {
  const body: BodyDimensions = {};
  for (const name of LENGTHS) {
    const cm = readLengthCm(texts.lengths[name]);
    const isTouched = texts.lengths[name] !== start.lengths[name];
    body[name] = isTouched ? (cm === null ? null : cm / 100) : (patient?.body_dimensions?.[name] ?? null);
  }
  return {
    given_name: texts.given.trim(),
    family_name: texts.family.trim(),
    birth_date: texts.birth || null,
    affected_side: texts.side || null,
    notes: texts.notes,
    body_dimensions: body,
  };
}

const FIELDS = {
  given_name: 'given',
  family_name: 'family',
  birth_date: 'birth',
  affected_side: 'side',
  notes: 'notes',
  body_dimensions: 'lengths',
} as const satisfies Record<keyof PatientIn & keyof PatientPatch, keyof Texts>;

/** Only what was changed: the rest may be newer by now than it was when the form was opened. */
function changesOf(input: PatientIn, texts: Texts, start: Texts): PatientPatch {
  const names = Object.keys(FIELDS) as (keyof typeof FIELDS)[];
  return Object.fromEntries(
    names.filter((name) => !isSame(texts[FIELDS[name]], start[FIELDS[name]])).map((name) => [name, input[name]]),
  );
}

/** A new patient or a change: names, side, and lengths in cm as a tape shows them; of a new one also the consent to treatment. */
export function PatientForm({ patient, onSaved, onCancel }: PatientFormProps) {
  const [start] = useState(() => textsOf(patient));
  const [texts, setTexts] = useState(start);
  const set = (some: Partial<Texts>) => setTexts((now) => ({ ...now, ...some }));
  const { given, family, birth, side, notes, lengths } = texts;
  const [agrees, setAgrees] = useState(false);
  // The consent is no part of it: it is said anew.
  const { guard, release } = useUnsaved({
    object: `patient:${patient?.id ?? 'new'}`,
    // With what it was typed over: a colleague may have changed other fields meanwhile.
    value: { texts, start },
    isChanged: !isSame(texts, start),
    onRestore: (stored) => setTexts(typedOver(start, stored.texts, stored.start)),
  });
  const add = useAddPatient(release);
  const edit = useEditPatient(patient?.id ?? '', release);
  const error = add.error ?? edit.error;
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
    const input = inputOf(texts, start, patient);
    if (patient) edit.mutate(changesOf(input, texts, start), { onSuccess: onSaved });
    else add.mutate({ ...input, agrees_to_treatment: agrees, is_another_person: isAnother }, { onSuccess: onSaved });
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
        <Button type="submit" loading={add.isPending || edit.isPending}>
          {t('action.save')}
        </Button>
      </Group>
    </form>
  );
}
