// A template in three steps: where the movement comes from, which repetitions count and how wide the band is, its name.
import { Button, Checkbox, Group, Select, Slider, TextInput } from '@mantine/core';
import { useDebouncedValue } from '@mantine/hooks';
import { IconPlayerRecord, IconRoute } from '@tabler/icons-react';
import { useMutation, useQuery } from '@tanstack/react-query';
import { useMemo, useState } from 'react';
import { Link, useNavigate, useSearchParams } from 'react-router';
import { api } from '../../api/client';
import { useSaveTemplate } from '../../api/changes';
import { useExercises, usePatient, usePatients, usePatientSessions, useSession, useTemplates } from '../../api/queries';
import type { SessionDetail, TemplateContent, TemplatePreviewIn, TemplateVersionDetail } from '../../api/types';
import { PhaseChart, PhaseLegend } from '../../charts/PhaseChart';
import { RadioCards } from '../../components/forms/Choice';
import { QueryBoundary, Empty, Problem, Waiting } from '../../components/Feedback';
import { Page } from '../../components/Page';
import { t, tOr } from '../../i18n';
import { day, duration, number, position } from '../../lib/format';
import { pickCurves } from '../../lib/assessment/comparison';
import { fullName } from '../../lib/people';
import { sessionTitle } from '../../lib/sessions';
import './RecordTemplate.css';
import './template.css';

const SHOWN_FIRST = 12;
const SHOWN_MORE = 24;
/** So many curves are shown at once. */
const FEW_CURVES = 3;
const NARROWEST = 0.5;
const WIDEST = 3;

/** Step one: a stored recording of this patient, or a new one. */
function Source({
  patientId,
  exerciseId,
  onPatient,
  onSession,
}: {
  patientId: string;
  exerciseId: string | null;
  onPatient: (id: string) => void;
  onSession: (id: string) => void;
}) {
  const patients = usePatients();
  const sessions = usePatientSessions(patientId);
  const analysed = (sessions.data ?? [])
    .filter((one) => one.state === 'analysed')
    .sort(
      (a, b) =>
        (exerciseId ? Number(b.exercise_id === exerciseId) - Number(a.exercise_id === exerciseId) : 0) ||
        Number(b.purpose === 'template') - Number(a.purpose === 'template'),
    );
  const [picked, setPicked] = useState('');
  const [shown, setShown] = useState(SHOWN_FIRST);
  const chosen = picked || (analysed[0]?.id ?? '');
  return (
    <section className="card stack" aria-labelledby="source">
      <h2 id="source">{t('template.stepSource')}</h2>
      <Select
        label={t('template.ofPatient')}
        description={t('template.ofPatientHelp')}
        searchable
        maw={420}
        data={(patients.data ?? [])
          .filter((one) => one.may_treat)
          .map((one) => ({ value: one.id, label: fullName(one) }))}
        value={patientId || null}
        onChange={(value) => value && onPatient(value)}
      />
      {patients.error && <Problem error={patients.error} />}
      {patientId && (
        <QueryBoundary of={sessions} lines={4}>
          {() =>
            analysed.length === 0 ? (
              <Empty level={3} icon={<IconRoute size={44} aria-hidden />} title={t('template.noRecordings')}>
                {t('template.noRecordingsText')}
              </Empty>
            ) : (
              <RadioCards
                legend={t('template.stored')}
                value={chosen}
                onChange={setPicked}
                options={analysed.slice(0, shown).map((one) => ({
                  value: one.id,
                  title: sessionTitle(one),
                  text: `${day(one.started_at ?? one.created_at)} · ${duration(one.duration_s)}${one.purpose === 'template' ? ` · ${t('session.forTemplate')}` : ''}`,
                }))}
              />
            )
          }
        </QueryBoundary>
      )}
      {(analysed.length > shown || sessions.hasNextPage) && (
        <div>
          <Button
            variant="default"
            size="sm"
            loading={sessions.isFetchingNextPage}
            onClick={() => {
              setShown(shown + SHOWN_MORE);
              if (analysed.length < shown + SHOWN_MORE && sessions.hasNextPage) void sessions.fetchNextPage();
            }}
          >
            {t('action.showMore')}
          </Button>
        </div>
      )}
      {patientId && (
        <Group>
          <Button disabled={!chosen} onClick={() => onSession(chosen)}>
            {t('template.useThis')}
          </Button>
          <Button
            component={Link}
            variant="default"
            leftSection={<IconPlayerRecord size={18} aria-hidden />}
            to={`/patients/${patientId}/sessions/new?purpose=template${exerciseId ? `&exercise=${exerciseId}` : ''}`}
          >
            {t('template.recordNow')}
          </Button>
        </Group>
      )}
    </section>
  );
}

/** Step two and three: which repetitions, how wide, whose, and its name. */
function Shape({
  session,
  exerciseId: wantedExercise,
  content,
  request,
  onRequest,
  isFresh,
}: {
  session: SessionDetail;
  exerciseId: string | null;
  content: TemplateContent;
  request: TemplatePreviewIn;
  onRequest: (request: TemplatePreviewIn) => void;
  isFresh: boolean;
}) {
  const navigate = useNavigate();
  const exercises = useExercises();
  const patient = usePatient(session.patient_id);
  const [exerciseId, setExerciseId] = useState<string | null>(wantedExercise ?? session.exercise_id ?? null);
  const templates = useTemplates(exerciseId, session.patient_id, exerciseId !== null);
  const [templateId, setTemplateId] = useState('new');
  const [forWhom, setForWhom] = useState<'patient' | 'clinic'>('patient');
  const [name, setName] = useState('');
  const [showsAll, setShowsAll] = useState(false);
  const save = useSaveTemplate();
  // The person's own choice shows at once; the curves follow when the service has averaged anew.
  const chosen = request.dropped;
  const dropped = useMemo(
    () =>
      new Set(
        content.repetitions.flatMap((one, index) =>
          (chosen ? chosen.includes(one.number) : !one.is_kept) ? [index] : [],
        ),
      ),
    [content, chosen],
  );
  const exercise = exercises.data?.find((one) => one.id === exerciseId);
  const curves = pickCurves(content.curves, showsAll, exercise?.primary_angle ?? null);
  const sides = content.sides ?? [];
  // Those of the preview have English names; on this page and from here on they have the therapist's.
  const phases = (content.phases ?? []).map((one) => ({
    ...one,
    name: tOr(`phase.${one.name.toLowerCase()}`, one.name),
  }));
  const accepted = content.repetitions.length - dropped.size;
  const existing = templates.data ?? [];
  const suggested = `${exercise?.name ?? sessionTitle(session)}${forWhom === 'patient' && patient.data ? `, ${patient.data.given_name}` : ''}`;
  const patientName = patient.data ? fullName(patient.data) : t('patient.title');

  const toggle = (position_: number) => {
    const next = new Set(dropped);
    if (next.has(position_)) next.delete(position_);
    else next.add(position_);
    onRequest({ ...request, dropped: [...next].map((index) => content.repetitions[index]?.number ?? 0) });
  };
  const scaleOf = (channel: string) => request.tolerance_scale?.[channel] ?? 1;
  const setScale = (channel: string, value: number) =>
    onRequest({ ...request, tolerance_scale: { ...request.tolerance_scale, [channel]: value } });
  const submit = () => {
    if (!exerciseId) return;
    save.mutate(
      {
        ...request,
        exercise_id: exerciseId,
        ...(phases.length > 0 && { phases }),
        patient_id: forWhom === 'patient' ? session.patient_id : null,
        template_id: templateId === 'new' ? null : templateId,
        name:
          templateId === 'new'
            ? name.trim() || suggested
            : (existing.find((one) => one.id === templateId)?.name ?? suggested),
      },
      {
        onSuccess: (version: TemplateVersionDetail) =>
          void navigate(
            `/exercises/${exerciseId}?version=${version.id}${forWhom === 'patient' ? `&patient=${session.patient_id}` : ''}`,
          ),
      },
    );
  };
  return (
    <>
      <section className="card" aria-labelledby="cut">
        <div className="card-head">
          <h2 id="cut">{t(sides.length > 0 ? 'template.stepStrides' : 'template.stepCut')}</h2>
          <span className="muted end">{t('template.found', { accepted, all: content.repetitions.length })}</span>
        </div>
        {sides.length > 1 && (
          <div className="stack foot-choice">
            <RadioCards
              legend={t('template.foot')}
              value={content.side ?? 'right'}
              onChange={(side) => onRequest({ ...request, side, dropped: null, tolerance_scale: {} })}
              columns={2}
              options={sides.map((value) => ({ value, title: t(`exercise.foot.${value}`) }))}
            />
          </div>
        )}
        <ul className="plain-list repetition-choice">
          {content.repetitions.map((one, index) => (
            <li key={one.number}>
              <Checkbox
                label={
                  <>
                    <span className="strong">
                      {t(sides.length > 0 ? 'repetition.stride' : 'repetition.numbered', { number: one.number })}
                    </span>{' '}
                    <span className="muted number">
                      {position(one.start_s)} · {number(one.end_s - one.start_s, 1)} s
                    </span>
                  </>
                }
                description={dropped.has(index) ? one.reason || t('template.droppedByYou') : undefined}
                checked={!dropped.has(index)}
                onChange={() => toggle(index)}
              />
            </li>
          ))}
        </ul>
      </section>
      <section className="card" aria-labelledby="band" aria-busy={!isFresh}>
        <div className="card-head">
          <h2 id="band">{t('template.stepBand')}</h2>
        </div>
        <p className="muted">{t('template.bandHelp')}</p>
        <PhaseLegend withOutside={false} patient={false} />
        <div className="template-curves">
          {curves.map((curve) => (
            <div key={curve.channel} className="template-curve">
              <h3>{curve.label}</h3>
              <PhaseChart
                curve={curve}
                phases={phases}
                left={dropped}
                height={230}
                bandScale={isFresh ? 1 : scaleOf(curve.channel)}
              />
              <div className="band-slider">
                <span id={`band-${curve.channel}`}>{t('template.bandWidth')}</span>
                <Slider
                  min={NARROWEST}
                  max={WIDEST}
                  step={0.05}
                  size="lg"
                  thumbSize={26}
                  label={null}
                  thumbLabel={`${t('template.bandWidth')}: ${curve.label}`}
                  marks={[{ value: 1 }]}
                  value={scaleOf(curve.channel)}
                  onChange={(value) => setScale(curve.channel, value)}
                />
                <span className="number strong">{number(scaleOf(curve.channel) * 100)} %</span>
              </div>
            </div>
          ))}
        </div>
        {content.curves.length > FEW_CURVES && (
          <Button mt={16} variant="default" aria-expanded={showsAll} onClick={() => setShowsAll(!showsAll)}>
            {showsAll ? t('compare.fewerCurves') : t('compare.moreCurves')}
          </Button>
        )}
      </section>
      <section className="card stack" aria-labelledby="name">
        <h2 id="name">{t('template.stepName')}</h2>
        <Select
          label={t('newSession.exercise')}
          maw={480}
          searchable
          data={(exercises.data ?? []).map((one) => ({ value: one.id, label: one.name }))}
          value={exerciseId}
          onChange={(value) => {
            setExerciseId(value);
            setTemplateId('new');
          }}
        />
        {existing.length > 0 && (
          <Select
            label={t('template.newOrVersion')}
            maw={480}
            data={[
              { value: 'new', label: t('template.new') },
              ...existing.map((one) => ({ value: one.id, label: t('template.nextVersion', { name: one.name }) })),
            ]}
            value={templateId}
            onChange={(value) => setTemplateId(value ?? 'new')}
          />
        )}
        {templateId === 'new' && (
          <>
            <RadioCards
              legend={t('template.forWhom')}
              value={forWhom}
              onChange={setForWhom}
              options={[
                {
                  value: 'patient',
                  title: t('template.forPatient', { name: patientName }),
                  text: t('template.forPatientText'),
                },
                { value: 'clinic', title: t('template.forClinic'), text: t('template.forClinicText') },
              ]}
            />
            <TextInput
              label={t('template.name')}
              placeholder={suggested}
              maxLength={200}
              maw={480}
              value={name}
              onChange={(event) => setName(event.currentTarget.value)}
            />
          </>
        )}
        {save.error && <Problem error={save.error} />}
        {accepted < 2 && (
          <p className="alert-text" role="alert">
            {t('template.tooFew')}
          </p>
        )}
        <div>
          <Button size="lg" disabled={!exerciseId || accepted < 2} loading={save.isPending} onClick={submit}>
            {t('template.save')}
          </Button>
        </div>
      </section>
    </>
  );
}

function Preview({ session, exerciseId }: { session: SessionDetail; exerciseId: string | null }) {
  const [request, setRequest] = useState<TemplatePreviewIn>({
    session_id: session.id,
    dropped: null,
    tolerance_scale: {},
  });
  const [settled] = useDebouncedValue(request, 350);
  const preview = useQuery({
    queryKey: ['template-preview', settled],
    queryFn: () => api.post('/api/templates/preview', { body: settled }),
    placeholderData: (before) => before,
    staleTime: Infinity,
    retry: false,
  });
  const isFresh = settled === request && !preview.isPlaceholderData;
  const back = useMutation({
    mutationFn: async () => setRequest({ session_id: session.id, dropped: null, tolerance_scale: {} }),
  });
  return (
    <>
      {preview.error && (
        <>
          <Problem error={preview.error} />
          {request.dropped !== null && (
            <div>
              <Button variant="default" onClick={() => back.mutate()}>
                {t('template.startOver')}
              </Button>
            </div>
          )}
        </>
      )}
      {preview.data ? (
        <Shape
          session={session}
          exerciseId={exerciseId}
          content={preview.data}
          request={request}
          onRequest={setRequest}
          isFresh={isFresh}
        />
      ) : (
        !preview.error && (
          <div className="card">
            <Waiting lines={6} height={44} />
          </div>
        )
      )}
    </>
  );
}

export function RecordTemplatePage() {
  const [search, setSearch] = useSearchParams();
  const sessionId = search.get('session') ?? '';
  const exerciseId = search.get('exercise');
  const session = useSession(sessionId);
  const set = (name: string, value: string) => setSearch((now) => (now.set(name, value), now));
  return (
    <Page
      title={t('template.record')}
      lead={t('template.lead')}
      crumbs={[{ to: '/exercises', text: t('nav.exercises') }]}
    >
      <div className="stack">
        {sessionId === '' ? (
          <Source
            patientId={search.get('patient') ?? ''}
            exerciseId={exerciseId}
            onPatient={(id) => set('patient', id)}
            onSession={(id) => set('session', id)}
          />
        ) : (
          <QueryBoundary of={session} lines={5}>
            {(data) => (
              <>
                <p className="muted">
                  {t('template.from', {
                    what: sessionTitle(data),
                    when: day(data.started_at ?? data.created_at),
                  })}{' '}
                  <Link
                    to={`/templates/record?patient=${data.patient_id}${exerciseId ? `&exercise=${exerciseId}` : ''}`}
                  >
                    {t('template.other')}
                  </Link>
                </p>
                <Preview key={data.id} session={data} exerciseId={exerciseId} />
              </>
            )}
          </QueryBoundary>
        )}
      </div>
    </Page>
  );
}
