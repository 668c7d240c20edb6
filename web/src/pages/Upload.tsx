// A whole recording from a file: which file, whose, in which format; then two bars, for sending and for working it out.
import { Button, Checkbox, Group, Progress } from '@mantine/core';
import { useMutation } from '@tanstack/react-query';
import { useState, type FormEvent } from 'react';
import { useSearchParams } from 'react-router';
import { upload } from '../api/client';
import { useEstimators, useFormats, useJob, useSession } from '../api/queries';
import type { Format, GuessedMapping, UploadIn } from '../api/types';
import { RadioCards } from '../components/forms/Choice';
import { isDateOrEmpty } from '../components/forms/DateField';
import { useUnsaved } from '../components/forms/useUnsaved';
import { Problem } from '../components/Feedback';
import { Page } from '../components/Page';
import { t } from '../i18n';
import { KINDS, kindOf } from '../kinds';
import { complete, type Pipeline } from '../lib/csv';
import { number } from '../lib/format';
import { AnalysisWait, JobProgress } from './session/AnalysisWait';
import { AboutPart, type About } from './upload/AboutPart';
import { FileDrop, FormatChoice } from './upload/FilePart';
import { FirstLook } from './upload/FirstLook';
import { hasField, HemisphereChoice, TablePart, type Hemisphere } from './upload/TablePart';
import { useTable } from './upload/useTable';

/** All that is typed here: the file itself cannot stay on the device. */
interface Draft {
  about: About;
  file: string | null;
  mapping: GuessedMapping | null;
  pipeline: Pipeline;
  hemisphere: Hemisphere;
}

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

const ofHemisphere = (chosen: Hemisphere) => (chosen === 'place' ? null : chosen);

export function UploadPage() {
  const [search] = useSearchParams();
  const estimators = useEstimators();
  const formats = useFormats();
  const [file, setFile] = useState<File | null>(null);
  const [chosenFormat, setFormat] = useState<string | null>(null);
  const [pipeline, setPipeline] = useState<Pipeline>('arm');
  const [first] = useState<About>({
    patientId: search.get('patient'),
    day: '',
    exerciseId: null,
    estimator: null,
    withLegs: false,
    knowsPose: false,
    pose: [0, 3],
    apartCm: null,
  });
  const [about, setAbout] = useState(first);
  const [hemisphere, setHemisphere] = useState<Hemisphere>('place');
  const [accepts, setAccepts] = useState(false);
  const [sent, setSent] = useState(0);
  /** Of an earlier time, for the same file once it is chosen again. */
  const [restored, setRestored] = useState<Draft | null>(null);
  const [restorations, setRestorations] = useState(0);
  const format = formats.data?.find((one) => one.name === chosenFormat) ?? null;
  const hasPipeline = format?.asks_pipeline ?? false;
  const kind = kindOf({ pipeline: (hasPipeline ? pipeline : format?.pipeline) ?? '' });
  const hasPose = format !== null && kind.needsPose;
  const tables = formats.data?.find((one) => one.needs_mapping);
  const isTable = (name: string) => tables?.endings.some((ending) => name.toLowerCase().endsWith(ending)) ?? false;
  // Also tables in a zip, and what no ending says: the answer is the kind, or what the file is instead of a recording.
  const isLookedAt = (name: string) => {
    const ending = name.toLowerCase().slice(name.lastIndexOf('.'));
    return isTable(name) || ending === '.zip' || !formats.data?.some((one) => one.endings.includes(ending));
  };
  const table = useTable((found) => {
    setFormat(found.format);
    setPipeline(found.pipeline);
  });
  const { mapping } = table;
  const send = useMutation({
    mutationFn: (form: FormData) => upload('/api/uploads', {}, form, setSent),
    onMutate: () => setSent(0),
  });
  const job = useJob(send.data?.id ?? null);
  const session = useSession(job.data?.status === 'complete' ? job.data.session_id : '');
  const isDone = job.data?.status === 'complete';
  const hasFailed = job.data?.status === 'failed';
  const unsaved = useUnsaved<Draft>({
    object: 'upload',
    value: { about, file: file?.name ?? null, mapping, pipeline, hemisphere },
    // Once it has arrived the service has it all; what it refuses is to be corrected here.
    isChanged: (file !== null || JSON.stringify(about) !== JSON.stringify(first)) && (!send.isSuccess || hasFailed),
    onRestore: (draft) => {
      setAbout(draft.about);
      setRestorations((before) => before + 1);
      setHemisphere(draft.hemisphere);
      if (file && file.name === draft.file && draft.mapping) table.lookAt(file, draft.pipeline, draft.mapping);
      else setRestored(draft.file === null ? null : draft);
    },
  });

  const take = (chosen: File) => {
    setFile(chosen);
    setAccepts(false);
    // What was chosen for the file before must not hold unseen for this one.
    const again = restored?.file === chosen.name ? restored : null;
    setHemisphere(again?.hemisphere ?? 'place');
    setRestored(null);
    send.reset();
    table.forget();
    setFormat((isTable(chosen.name) ? tables : formatOf(chosen.name, formats.data ?? []))?.name ?? null);
    if (isLookedAt(chosen.name))
      table.lookAt(chosen, again?.mapping ? again.pipeline : null, again?.mapping ?? undefined);
  };
  const choosePipeline = (chosen: Pipeline) => {
    setPipeline(chosen);
    if (format?.needs_mapping && file) table.lookAt(file, chosen);
  };
  const chooseHemisphere = (chosen: Hemisphere) => {
    setHemisphere(chosen);
    if (file && mapping && format?.needs_mapping) table.change(file, mapping, ofHemisphere(chosen));
  };
  const orientation = about.estimator ?? estimators.data?.[0]?.name;
  const isMapped = !format?.needs_mapping || (mapping !== null && complete(mapping, kind.hasPlaces) !== null);
  // Packets have the time of their arrival; of other files somebody says the day, so that it counts for that day.
  const needsDay = format !== null && format.name !== 'packet_log';
  const isDayKnown = isDateOrEmpty(about.day) && (about.day !== '' || !needsDay);
  const isReady = isDayKnown && file !== null && about.patientId !== null && orientation !== undefined && isMapped;
  const lacking = lackingOf({ file, about, isLooking: table.isLooking, isMapped, isDayKnown });
  const submit = (event: FormEvent) => {
    event.preventDefault();
    if (!isReady || !file || !about.patientId || !orientation) return;
    const declaration: UploadIn = {
      patient_id: about.patientId,
      exercise_id: about.exerciseId,
      purpose: 'exercise',
      format: chosenFormat,
      file_name: file.name.slice(-200),
      pipeline: hasPipeline ? pipeline : 'arm',
      csv: format?.needs_mapping && mapping ? complete(mapping, kind.hasPlaces) : null,
      orientation,
      calibration_pose_s: about.knowsPose && hasPose ? about.pose : null,
      feet_apart_m: kind.asksFeetApart && about.apartCm !== null ? about.apartCm / 100 : null,
      hemisphere: ofHemisphere(hemisphere),
      with_legs: about.withLegs && hasPose,
      accept_implausible: accepts,
      recorded_at: about.day === '' ? null : noonOf(about.day),
    };
    const form = new FormData();
    form.set('declaration', JSON.stringify(declaration));
    form.set('file', file);
    send.mutate(form);
  };
  const isRefused = hasFailed && job.data?.is_implausible === true;
  return (
    <Page narrow title={t('upload.heading')} lead={t('upload.lead')}>
      <form className="stack" onSubmit={submit}>
        {unsaved.guard}
        <section className="card stack">
          {restored?.file && !file && <p role="status">{t('upload.fileAgain', { name: restored.file })}</p>}
          {formats.data && <FileDrop file={file} formats={formats.data} onFile={take} />}
          {formats.error && <Problem error={formats.error} />}
          {file && !table.isLooking && (
            <FormatChoice
              key={`format of ${file.name} ${file.lastModified}`}
              value={format}
              formats={formats.data ?? []}
              isRecognised={table.seen !== null || !isLookedAt(file.name)}
              onChange={setFormat}
            />
          )}
          {file && hasPipeline && !table.isLooking && (
            <RadioCards
              legend={t('upload.pipeline')}
              value={pipeline}
              onChange={choosePipeline}
              options={KINDS.flatMap(({ pipeline: value, upload: offer }) =>
                offer ? [{ value: value as Pipeline, title: offer.title(), text: offer.text() }] : [],
              )}
            />
          )}
          {table.isLooking && <p className="muted">{t('upload.looking')}</p>}
          {table.error && <Problem error={table.error} />}
          {file && format && !format.needs_mapping && table.seen && !table.isLooking && (
            <FirstLook seen={table.seen} isChanging={false} />
          )}
          {file && format?.needs_mapping && table.seen && mapping && !table.isLooking && (
            <TablePart
              key={`table ${file.name} ${file.lastModified}`}
              seen={table.seen}
              mapping={mapping}
              isChanging={table.isChanging}
              hasPlaces={kind.hasPlaces}
              hemisphere={hemisphere}
              onMapping={(changed) => table.change(file, changed, ofHemisphere(hemisphere))}
              onHemisphere={chooseHemisphere}
            />
          )}
        </section>
        <AboutPart
          // A field for a day shows what was typed in it: it begins anew with what is restored.
          key={restorations}
          value={about}
          onChange={(change) => setAbout({ ...about, ...change })}
          needsDay={needsDay}
          hasPose={hasPose}
          asksFeetApart={kind.asksFeetApart ?? false}
          orientation={orientation}
        />
        {send.error && <Problem error={send.error} />}
        {(send.isPending || send.isSuccess) && (
          <section className="card stack" aria-live="polite">
            <Sending share={send.isSuccess ? 1 : sent} />
            {job.data && <JobProgress job={job.data} />}
            {job.error && <Problem error={job.error} />}
            {isRefused && (
              <>
                {!(format?.needs_mapping && hasField(mapping)) && (
                  <HemisphereChoice value={hemisphere} onChange={chooseHemisphere} />
                )}
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

/** What must be said before the file can be sent, as a key of the catalogue. */
function lackingOf(known: {
  file: File | null;
  about: About;
  isLooking: boolean;
  isMapped: boolean;
  isDayKnown: boolean;
}) {
  if (known.file === null) return 'upload.lacksFile';
  if (known.isLooking) return null;
  if (!known.isMapped) return 'upload.lacksColumns';
  if (known.about.patientId === null) return 'upload.lacksPatient';
  return known.isDayKnown ? null : 'upload.lacksDay';
}

function Sending({ share }: { share: number }) {
  return (
    <div>
      <div className="line-head">
        <span className="strong">{t('upload.sending')}</span>
        <span className="muted number">{number(100 * share)} %</span>
      </div>
      <Progress size="lg" transitionDuration={0} value={100 * share} aria-label={t('upload.sending')} />
    </div>
  );
}
