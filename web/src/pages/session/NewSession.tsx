import { Button, Group, NumberInput, Select, Switch } from '@mantine/core';
import { useState, type FormEvent } from 'react';
import { useNavigate, useParams, useSearchParams } from 'react-router';
import {
  useEstimators,
  useExercises,
  useMagneticSources,
  useNewSession,
  useNewSourceSession,
  usePatient,
  usePrescriptions,
} from '../../api/queries';
import type { Estimator, Patient, Placement, SessionIn } from '../../api/types';
import { RadioCards } from '../../components/forms/Choice';
import { Answer, Problem } from '../../components/Feedback';
import { Page } from '../../components/Page';
import { PlacementChoice } from '../../components/forms/PlacementChoice';
import { t } from '../../i18n';
import { placementList } from '../../lib/channels';
import { isWalk as isWalking } from '../../lib/exercises';
import { day } from '../../lib/format';
import {
  isForbidden,
  isSafe,
  sourceParameters,
  UNASKED,
  USUAL,
  wornFor,
  type Use,
} from '../../kinds/magnetic/magneticSetup';
import { KINDS } from '../../kinds';
import { FEET, placementProblem, suggestedPlacements } from '../../lib/placements';
import { ImplantQuestions } from '../../kinds/magnetic/ImplantQuestions';
import { SourceChoice } from '../../kinds/magnetic/SourceChoice';

/** Those a therapist chooses between; the others are for comparison. */
const SHOWN_FIRST = 2;
type Kind = NonNullable<SessionIn['pipeline']>;
const SHOES: Placement[] = ['heel_left', 'forefoot_left', 'heel_right', 'forefoot_right'];

function Form({ patient }: { patient: Patient }) {
  const navigate = useNavigate();
  const [search] = useSearchParams();
  const purpose = search.get('purpose') === 'template' ? 'template' : 'exercise';
  const exercises = useExercises();
  const prescriptions = usePrescriptions(patient.id);
  const estimators = useEstimators();
  const createPlain = useNewSession();
  const createWithSource = useNewSourceSession();
  const prescribed = prescriptions.data ?? [];
  const [picked, setPicked] = useState<string | null>(search.get('exercise'));
  const exerciseId = picked ?? prescribed[0]?.exercise_id ?? null;
  const [placements, setPlacements] = useState<Placement[]>(() => suggestedPlacements(patient.affected_side));
  const [orientation, setOrientation] = useState<string | null>(null);
  const [constrain, setConstrain] = useState(false);
  const [useMounting, setUseMounting] = useState(false);
  const walking = (exercises.data ?? []).find((one) => one.id === exerciseId)?.movement;
  const [kind, setKind] = useState<Kind | null>(null);
  const pipeline = kind ?? (isWalking(walking) ? 'gait' : 'arm');
  const isWalk = pipeline === 'gait';
  const isMagnetic = pipeline === 'relative_pose';
  const isArm = pipeline === 'arm';
  const begin = KINDS.find((one) => one.pipeline === pipeline)?.begin;
  const [wornAs, setWornAs] = useState('0');
  const wornHere = begin?.worn[Number(wornAs)]?.placements ?? placements;
  const create = isMagnetic ? createWithSource : createPlain;
  const [use, setUse] = useState<Use>('back');
  const [worn, setWorn] = useState(() => wornFor('back', patient.affected_side));
  const [coils, setCoils] = useState(USUAL);
  const sources = useMagneticSources(isMagnetic);
  const [sourceId, setSourceId] = useState<string | null>(null);
  const [implants, setImplants] = useState(UNASKED);
  const mayFire = isSafe(implants) && worn.sensors.length > 0;
  const [hasShoes, setShoes] = useState(false);
  const [apartCm, setApartCm] = useState<number | null>(null);
  const problem = isArm ? placementProblem(placements) : null;
  const names = new Map((exercises.data ?? []).map((one) => [one.id, one.name]));
  const prescribedIds = new Set(prescribed.map((one) => one.exercise_id));
  const groups = [
    {
      group: t('newSession.prescribed'),
      items: [...prescribedIds].map((id) => ({ value: id, label: names.get(id) ?? id })),
    },
    {
      group: t('newSession.others'),
      items: (exercises.data ?? [])
        .filter((one) => !prescribedIds.has(one.id))
        .map((one) => ({ value: one.id, label: one.name })),
    },
  ].filter((group) => group.items.length > 0);

  // What is to be measured cannot be known already.
  const wornId = use === 'bench' ? null : sourceId;
  const submit = (event: FormEvent) => {
    event.preventDefault();
    if (problem || (isMagnetic && !mayFire)) return;
    const goOn = { onSuccess: (session: { id: string }) => void navigate(`/sessions/${session.id}/live`) };
    if (isMagnetic) {
      createWithSource.mutate(
        {
          patient_id: patient.id,
          pipeline,
          placements: [worn.source, ...worn.sensors],
          orientation_parameters: sourceParameters(worn, wornId ? USUAL : coils, use),
          ...(wornId ? { magnetic_source_id: wornId } : {}),
          use_mounting: false,
        },
        goOn,
      );
      return;
    }
    createPlain.mutate(
      {
        patient_id: patient.id,
        exercise_id: exerciseId,
        prescription_id:
          purpose === 'exercise' ? (prescribed.find((one) => one.exercise_id === exerciseId)?.id ?? null) : null,
        purpose,
        pipeline,
        placements: isWalk ? (hasShoes ? SHOES : FEET) : [...wornHere],
        ...(isWalk && apartCm !== null ? { feet_apart_m: apartCm / 100 } : {}),
        ...(orientation ? { orientation } : {}),
        constrain_joint_headings: constrain,
        use_mounting: useMounting,
      },
      goOn,
    );
  };
  return (
    <form className="card stack form-card" onSubmit={submit}>
      {create.error && <Problem error={create.error} />}
      {!isMagnetic && (
        <Select
          label={t('newSession.exercise')}
          searchable
          data={groups}
          value={exerciseId}
          onChange={setPicked}
          placeholder={t('prescription.chooseExercise')}
          nothingFoundMessage={t('newSession.noExercise')}
          maw={480}
        />
      )}
      <RadioCards<Kind>
        legend={t('newSession.kind')}
        value={pipeline}
        onChange={setKind}
        options={[
          { value: 'arm', title: t('newSession.arms'), text: t('newSession.armsText') },
          { value: 'gait', title: t('newSession.feet'), text: t('newSession.feetText') },
          ...(purpose === 'template'
            ? []
            : [
                { value: 'relative_pose' as const, title: t('magnetic.kind'), text: t('magnetic.kindText') },
                ...KINDS.flatMap(({ pipeline, begin }) =>
                  begin ? [{ value: pipeline as Kind, title: begin.title(), text: begin.text() }] : [],
                ),
              ]),
        ]}
      />
      {begin && (
        <RadioCards
          legend={t('newSession.worn')}
          value={wornAs}
          onChange={setWornAs}
          options={begin.worn.map(({ title }, index) => ({ value: String(index), title: title() }))}
        />
      )}
      {isWalk && (
        <Switch
          label={t('newSession.shoes')}
          description={t('newSession.shoesHelp')}
          checked={hasShoes}
          onChange={(event) => setShoes(event.currentTarget.checked)}
        />
      )}
      {isWalk && (
        <NumberInput
          label={t('newSession.apart')}
          description={t('newSession.apartHelp')}
          value={apartCm ?? ''}
          onChange={(value) => setApartCm(typeof value === 'number' ? value : null)}
          min={0}
          max={60}
          maw={480}
        />
      )}
      {isMagnetic && (
        <>
          <SourceChoice
            use={use}
            worn={worn}
            coils={coils}
            side={patient.affected_side}
            sources={use === 'bench' ? [] : (sources.data ?? [])}
            sourceId={wornId}
            onSource={setSourceId}
            onUse={(nextUse, nextWorn) => {
              setUse(nextUse);
              setWorn(nextWorn);
            }}
            onCoils={setCoils}
          />
          <section className="stack" aria-labelledby="implants">
            <h2 id="implants" className="protocol-title">
              {t('magnetic.safety')}
            </h2>
            <ImplantQuestions value={implants} onChange={setImplants} />
          </section>
        </>
      )}
      {isArm && <PlacementChoice value={placements} onChange={setPlacements} />}
      {problem && (
        <p className="alert-text" role="alert">
          {t(problem)}
        </p>
      )}
      {isArm && (
        <Answer of={estimators} lines={2}>
          {(list) => {
            const live = list.filter((one) => !one.is_offline);
            const card = (one: Estimator) => ({ value: one.name, title: one.title, text: one.description });
            const value = orientation ?? live[0]?.name ?? '';
            return (
              <div>
                <RadioCards
                  legend={t('newSession.estimator')}
                  help={t('newSession.estimatorHelp')}
                  value={value}
                  onChange={setOrientation}
                  options={live.slice(0, SHOWN_FIRST).map(card)}
                />
                {live.length > SHOWN_FIRST && (
                  <details className="as-table">
                    <summary>{t('newSession.otherEstimators')}</summary>
                    <RadioCards
                      legend={t('newSession.otherEstimators')}
                      value={value}
                      onChange={setOrientation}
                      options={live.slice(SHOWN_FIRST).map(card)}
                    />
                  </details>
                )}
              </div>
            );
          }}
        </Answer>
      )}
      {isArm && (
        <Switch
          label={t('newSession.constrain')}
          description={t('newSession.constrainHelp')}
          checked={constrain}
          onChange={(event) => setConstrain(event.currentTarget.checked)}
        />
      )}
      {isArm && patient.has_mounting && (
        <Switch
          label={t('newSession.mounting')}
          description={
            t('newSession.mountingHelp') +
            (patient.mounting
              ? ` ${t('newSession.mountingOf', { day: day(patient.mounting.updated_at), places: placementList(patient.mounting.placements) })}`
              : '')
          }
          checked={useMounting}
          onChange={(event) => setUseMounting(event.currentTarget.checked)}
        />
      )}
      {isMagnetic && !isSafe(implants) && !isForbidden(implants) && <p className="muted">{t('magnetic.askFirst')}</p>}
      <Group justify="flex-end">
        <Button variant="default" onClick={() => void navigate(`/patients/${patient.id}`)}>
          {t('action.cancel')}
        </Button>
        <Button type="submit" disabled={problem !== null || (isMagnetic && !mayFire)} loading={create.isPending}>
          {t('newSession.go')}
        </Button>
      </Group>
    </form>
  );
}

export function NewSessionPage() {
  const { patientId = '' } = useParams();
  const [search] = useSearchParams();
  const patient = usePatient(patientId);
  const name = patient.data ? `${patient.data.given_name} ${patient.data.family_name}` : t('patient.title');
  return (
    <Page
      narrow
      title={search.get('purpose') === 'template' ? t('newSession.titleTemplate') : t('newSession.title')}
      lead={patient.data ? t('newSession.lead', { name }) : undefined}
      crumbs={[
        { to: '/', text: t('nav.caseload') },
        { to: `/patients/${patientId}`, text: name },
      ]}
    >
      <Answer of={patient} lines={8}>
        {(data) => <Form patient={data} />}
      </Answer>
    </Page>
  );
}
