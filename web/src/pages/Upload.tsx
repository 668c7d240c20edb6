// A whole recording from a file: which file, whose, in which format; then two bars, for sending and for working it out.
import { Button, Checkbox, Group, NumberInput, Progress, Select, Switch } from '@mantine/core';
import { useMutation } from '@tanstack/react-query';
import { useRef, useState, type FormEvent } from 'react';
import { useSearchParams } from 'react-router';
import { byHand, upload } from '../api/client';
import { useEstimators, useExercises, useFormats, useJob, usePatients, useSession } from '../api/queries';
import type { Format, GuessedMapping, Job, Placement, PreviewIn, TablePreview, UploadIn } from '../api/types';
import { RadioCards } from '../components/forms/Choice';
import { CsvMappingForm } from '../components/forms/CsvMappingForm';
import { Advanced } from '../components/forms/Advanced';
import { DateField, isDateOrEmpty } from '../components/forms/DateField';
import { Problem } from '../components/Feedback';
import { Page } from '../components/Page';
import { t } from '../i18n';
import { KINDS, kindOf } from '../kinds';
import { fullName } from '../lib/people';
import { LEG_PLACEMENTS } from '../lib/placements';
import { beginningOf, complete, type Pipeline } from '../lib/csv';
import { number } from '../lib/format';
import { AnalysisWait, JobProgress } from './session/AnalysisWait';
import { FileDrop, FormatChoice } from './upload/FilePart';

const PLACEMENTS: Placement[] = [
  'sternum',
  'upper_arm_right',
  'forearm_right',
  'hand_right',
  'upper_arm_left',
  'forearm_left',
  'hand_left',
  'pelvis',
  'head',
  'shoulder_left',
  'shoulder_right',
  ...LEG_PLACEMENTS,
];
/** `place`: where the service is. */
type Hemisphere = NonNullable<UploadIn['hemisphere']> | 'place';
const HEMISPHERES: Hemisphere[] = ['place', 'north', 'south', 'unknown'];

/** The one format whose files alone end so; null: only the contents say it, and the service reads those. */
function formatOf(name: string, formats: readonly Format[]): Format | null {
  const isSo = (one: Format) => one.endings.some((ending) => name.toLowerCase().endsWith(ending));
  const [first, second] = formats.filter(isSo);
  return first && !second ? first : null;
}

/** Noon of a day here, or now where that is earlier: nothing was recorded in the future. */
function noonOf(day: string): string {
  return new Date(Math.min(new Date(`${day}T12:00:00`).getTime(), Date.now())).toISOString();
}

export function UploadPage() {
  const [search] = useSearchParams();
  const patients = usePatients();
  const exercises = useExercises();
  const estimators = useEstimators();
  const [file, setFile] = useState<File | null>(null);
  const formats = useFormats();
  const [chosenFormat, setFormat] = useState<string | null>(null);
  const [patientId, setPatientId] = useState<string | null>(search.get('patient'));
  const [exerciseId, setExerciseId] = useState<string | null>(null);
  const [wantedEstimator, setWantedEstimator] = useState<string | null>(null);
  const [mapping, setMapping] = useState<GuessedMapping | null>(null);
  const [pipeline, setPipeline] = useState<Pipeline>('arm');
  const [apartCm, setApartCm] = useState<number | null>(null);
  const format = formats.data?.find((one) => one.name === chosenFormat) ?? null;
  const hasPipeline = format?.asks_pipeline ?? false;
  const held = hasPipeline ? pipeline : format?.pipeline;
  const kind = kindOf({ pipeline: held ?? '' });
  const hasPose = format !== null && kind.needsPose;
  const table = formats.data?.find((one) => one.needs_mapping);
  const isTable = (name: string) => table?.endings.some((ending) => name.toLowerCase().endsWith(ending)) ?? false;
  // Also tables in a zip, and what no ending says: the answer is the kind, or what the file is instead of a recording.
  const isLookedAt = (name: string) => {
    const ending = name.toLowerCase().slice(name.lastIndexOf('.'));
    return isTable(name) || ending === '.zip' || !formats.data?.some((one) => one.endings.includes(ending));
  };
  const [knowsPose, setKnowsPose] = useState(false);
  const [pose, setPose] = useState<[number, number]>([0, 3]);
  const [withLegs, setWithLegs] = useState(false);
  const [hemisphere, setHemisphere] = useState<Hemisphere>('place');
  const [accepts, setAccepts] = useState(false);
  const [day, setDay] = useState('');
  const [sent, setSent] = useState(0);
  const send = useMutation({
    mutationFn: (form: FormData) => upload<Job>('/api/uploads', form, setSent),
    onMutate: () => setSent(0),
  });
  const job = useJob(send.data?.id ?? null);
  const session = useSession(job.data?.status === 'complete' ? job.data.session_id : '');

  // The answer to an earlier file or choice must not overwrite that to the newest.
  const newest = useRef(0);
  const look = useMutation({
    mutationFn: async ({ chosen, asked }: { chosen: File; asked: Pipeline | null; turn: number }) =>
      byHand.post<TablePreview>('/api/uploads/preview', {
        file_name: chosen.name.slice(-200),
        beginning: await beginningOf(chosen),
        pipeline: asked,
      } satisfies PreviewIn),
    onSuccess: (found, { turn }) => {
      if (turn !== newest.current) return;
      setFormat(found.format);
      setPipeline(found.pipeline);
      setMapping(found.mapping ?? { signals: [] });
    },
  });
  const lookAt = (chosen: File, asked: Pipeline | null) => {
    newest.current += 1;
    look.mutate({ chosen, asked, turn: newest.current });
  };
  const take = (chosen: File) => {
    setFile(chosen);
    setAccepts(false);
    // Shown only once a file was refused: what was chosen for the one before must not hold unseen.
    setHemisphere('place');
    send.reset();
    look.reset();
    setMapping(null);
    setFormat((isTable(chosen.name) ? table : formatOf(chosen.name, formats.data ?? []))?.name ?? null);
    if (isLookedAt(chosen.name)) lookAt(chosen, null);
  };
  const choosePipeline = (chosen: Pipeline) => {
    setPipeline(chosen);
    if (format?.needs_mapping && file) lookAt(file, chosen);
  };
  const orientation = wantedEstimator ?? estimators.data?.[0]?.name;
  const isMapped = !format?.needs_mapping || (mapping !== null && complete(mapping, kind.hasPlaces) !== null);
  // Packets have the time of their arrival; of other files somebody says the day, so that it counts for that day.
  const needsDay = format !== null && format.name !== 'packet_log';
  const isDayKnown = isDateOrEmpty(day) && (day !== '' || !needsDay);
  const isReady = isDayKnown && file !== null && patientId !== null && orientation !== undefined && isMapped;
  const lacking =
    file === null
      ? 'upload.lacksFile'
      : look.isPending
        ? null
        : !isMapped
          ? 'upload.lacksColumns'
          : patientId === null
            ? 'upload.lacksPatient'
            : !isDayKnown
              ? 'upload.lacksDay'
              : null;
  const submit = (event: FormEvent) => {
    event.preventDefault();
    if (!isReady || !file || !patientId || !orientation) return;
    const declaration: UploadIn = {
      patient_id: patientId,
      exercise_id: exerciseId,
      purpose: 'exercise',
      format: chosenFormat,
      file_name: file.name.slice(-200),
      pipeline: hasPipeline ? pipeline : 'arm',
      csv: format?.needs_mapping && mapping ? complete(mapping, kind.hasPlaces) : null,
      orientation,
      calibration_pose_s: knowsPose && hasPose ? pose : null,
      feet_apart_m: kind.asksFeetApart && apartCm !== null ? apartCm / 100 : null,
      hemisphere: hemisphere === 'place' ? null : hemisphere,
      with_legs: withLegs && hasPose,
      accept_implausible: accepts,
      recorded_at: day === '' ? null : noonOf(day),
    };
    const form = new FormData();
    form.set('declaration', JSON.stringify(declaration));
    form.set('file', file);
    send.mutate(form);
  };
  const isDone = job.data?.status === 'complete';
  const hasFailed = job.data?.status === 'failed';
  const isRefused = hasFailed && job.data?.is_implausible === true;
  return (
    <Page narrow title={t('upload.heading')} lead={t('upload.lead')}>
      <form className="stack" onSubmit={submit}>
        <section className="card stack">
          {formats.data && <FileDrop file={file} formats={formats.data} onFile={take} />}
          {formats.error && <Problem error={formats.error} />}
          {file && !look.isPending && (
            <FormatChoice
              key={`${file.name} ${file.lastModified}`}
              value={format}
              formats={formats.data ?? []}
              isRecognised={look.isSuccess || !isLookedAt(file.name)}
              onChange={setFormat}
            />
          )}
          {file && hasPipeline && !look.isPending && (
            <RadioCards
              legend={t('upload.pipeline')}
              value={pipeline}
              onChange={choosePipeline}
              options={KINDS.flatMap(({ pipeline: value, upload: offer }) =>
                offer ? [{ value: value as Pipeline, title: offer.title(), text: offer.text() }] : [],
              )}
            />
          )}
          {look.isPending && <p className="muted">{t('upload.looking')}</p>}
          {look.error && <Problem error={look.error} />}
          {format?.needs_mapping && look.data && mapping && (
            <>
              {look.data.missing.map((reason) => (
                <p key={reason} className="alert-text">
                  {reason}
                </p>
              ))}
              <CsvMappingForm
                head={look.data}
                hasPlaces={kind.hasPlaces}
                placements={PLACEMENTS}
                value={mapping}
                onChange={setMapping}
              />
            </>
          )}
        </section>
        <section className="card stack">
          <Select
            label={t('upload.patient')}
            searchable
            maw={480}
            data={(patients.data ?? [])
              .filter((one) => one.may_treat)
              .map((one) => ({ value: one.id, label: fullName(one) }))}
            value={patientId}
            onChange={setPatientId}
          />
          {patients.error && <Problem error={patients.error} />}
          <DateField
            label={t('upload.day')}
            description={t(needsDay ? 'upload.dayHelp' : 'upload.dayOfFile')}
            value={day}
            onChange={setDay}
          />
          <Select
            label={t('upload.exercise')}
            searchable
            clearable
            maw={480}
            data={(exercises.data ?? []).map((one) => ({ value: one.id, label: one.name }))}
            value={exerciseId}
            onChange={setExerciseId}
          />
          {kind.asksFeetApart ? (
            <NumberInput
              label={t('newSession.apart')}
              description={t('newSession.apartHelp')}
              value={apartCm ?? ''}
              onChange={(value) => setApartCm(typeof value === 'number' ? value : null)}
              min={0}
              max={60}
              maw={480}
            />
          ) : (
            <>
              {hasPose && (
                <>
                  <Switch
                    label={t('upload.withLegs')}
                    description={t('upload.withLegsHelp')}
                    checked={withLegs}
                    onChange={(event) => setWithLegs(event.currentTarget.checked)}
                  />
                  <Switch
                    label={t('upload.knowsPose')}
                    description={t('upload.knowsPoseHelp')}
                    checked={knowsPose}
                    onChange={(event) => setKnowsPose(event.currentTarget.checked)}
                  />
                </>
              )}
            </>
          )}
          {knowsPose && hasPose && (
            <Group>
              <NumberInput
                label={t('upload.poseFrom')}
                suffix=" s"
                min={0}
                w={140}
                value={pose[0]}
                onChange={(value) => setPose([Number(value) || 0, pose[1]])}
              />
              <NumberInput
                label={t('upload.poseUntil')}
                suffix=" s"
                min={0}
                w={140}
                value={pose[1]}
                onChange={(value) => setPose([pose[0], Number(value) || 0])}
              />
            </Group>
          )}
          {!kind.asksFeetApart && (
            <Advanced>
              <Select
                label={t('newSession.estimator')}
                maw={480}
                data={(estimators.data ?? []).map((one) => ({ value: one.name, label: one.title }))}
                value={orientation ?? null}
                onChange={setWantedEstimator}
                description={estimators.data?.find((one) => one.name === orientation)?.description}
              />
            </Advanced>
          )}
        </section>
        {send.error && <Problem error={send.error} />}
        {(send.isPending || send.isSuccess) && (
          <section className="card stack" aria-live="polite">
            <div>
              <div className="line-head">
                <span className="strong">{t('upload.sending')}</span>
                <span className="muted number">{number(100 * (send.isSuccess ? 1 : sent))} %</span>
              </div>
              <Progress
                size="lg"
                transitionDuration={0}
                value={100 * (send.isSuccess ? 1 : sent)}
                aria-label={t('upload.sending')}
              />
            </div>
            {job.data && <JobProgress job={job.data} />}
            {job.error && <Problem error={job.error} />}
            {isRefused && (
              <>
                <Select
                  label={t('upload.hemisphere')}
                  description={t('upload.hemisphereHelp')}
                  maw={480}
                  allowDeselect={false}
                  data={HEMISPHERES.map((value) => ({ value, label: t(`upload.hemisphere.${value}`) }))}
                  value={hemisphere}
                  onChange={(value) => setHemisphere(value ?? 'place')}
                />
                <Checkbox
                  label={t('upload.accept')}
                  description={t('upload.acceptHelp')}
                  checked={accepts}
                  onChange={(event) => setAccepts(event.currentTarget.checked)}
                />
              </>
            )}
          </section>
        )}
        {isDone && session.data && <AnalysisWait session={session.data} state={session.data.state} />}
        <Group justify="flex-end">
          {lacking && <p className="muted">{t(lacking)}</p>}
          <Button
            type="submit"
            size="lg"
            disabled={!isReady || (send.isSuccess && !hasFailed)}
            loading={send.isPending}
          >
            {t(hasFailed ? 'upload.again' : 'upload.send')}
          </Button>
        </Group>
      </form>
    </Page>
  );
}
