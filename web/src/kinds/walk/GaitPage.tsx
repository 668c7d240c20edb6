// A walk: its result, the footprints with mass and pressure, left beside right, curves over the cycle, every stride.
import { Button, Select } from '@mantine/core';
import { IconArrowsDiff, IconCube, IconFileText, IconShoe } from '@tabler/icons-react';
import { useState } from 'react';
import { Link, useParams, useSearchParams } from 'react-router';
import { useGait, usePatient, useSession, useWalks } from '../../api/queries';
import type { CycleCurve, Gait, Patient } from '../../api/types';
import { CycleChart, CycleLegend } from '../../charts/CycleChart';
import { QueryBoundary, Empty, Problem } from '../../components/Feedback';
import { Page } from '../../components/Page';
import { t } from '../../i18n';
import { dateTime, number, withUnit } from '../../lib/format';
import { fullName, patientCrumbs } from '../../lib/people';
import { footOf } from './gait';
import { MapCard } from './views/MapCard';
import { StrideTable, type ChosenStride } from './views/StrideTable';
import { TestResult } from './views/TestResult';
import { WalkNumbers } from './views/WalkNumbers';
import './GaitPage.css';

function Curves({ gait, before }: { gait: Gait; before: Gait | null }) {
  const names = [...new Set(gait.feet.flatMap((foot) => foot.curves.map((curve) => curve.name)))];
  const of = (walk: Gait | null, side: 'left' | 'right', name: CycleCurve['name']) =>
    walk ? footOf(walk, side)?.curves.find((one) => one.name === name) : undefined;
  return (
    <section className="card" aria-labelledby="curves">
      <div className="card-head">
        <h2 id="curves">{t('cycle.title')}</h2>
      </div>
      {names.length === 0 ? (
        <p className="muted">{t('cycle.few')}</p>
      ) : (
        <>
          <div className="cycle-grid">
            {names.map((name) => (
              <figure key={name} className="cycle">
                <figcaption className="strong">
                  {withUnit(t(`cycle.${name}`), (of(gait, 'left', name) ?? of(gait, 'right', name))?.unit)}
                </figcaption>
                <CycleChart
                  name={t(`cycle.${name}`)}
                  left={of(gait, 'left', name)}
                  right={of(gait, 'right', name)}
                  beforeLeft={of(before, 'left', name)}
                  beforeRight={of(before, 'right', name)}
                />
              </figure>
            ))}
          </div>
          <CycleLegend hasBefore={before !== null} />
          <p className="muted small">{t('cycle.help')}</p>
        </>
      )}
    </section>
  );
}

function Loaded({ gait, patient }: { gait: Gait; patient: Patient | undefined }) {
  const [search, setSearch] = useSearchParams();
  const walks = useWalks(patient?.id ?? '');
  const others = (walks.data ?? []).filter((one) => one.session_id !== gait.session_id);
  const wanted = others.find((one) => one.session_id === search.get('before'))?.session_id ?? null;
  const before = useGait(wanted);
  const [selected, setSelected] = useState<ChosenStride | null>(null);
  const earlier = wanted === null ? null : (before.data ?? null);
  const hasStrides = gait.feet.some((foot) => foot.strides.length > 0);
  if (!hasStrides) {
    return (
      <div className="stack">
        <Empty icon={<IconShoe size={42} aria-hidden />} title={t('walk.none')}>
          {t('walk.noneText')}
        </Empty>
        {gait.reasons.length > 0 && (
          <ul className="card">
            {gait.reasons.map((reason) => (
              <li key={reason}>{reason}</li>
            ))}
          </ul>
        )}
      </div>
    );
  }
  return (
    <div className="stack">
      {patient && others.length > 0 && (
        <div className="before-choice">
          <Select
            label={t('before.choose')}
            clearable
            placeholder={t('before.none')}
            value={wanted}
            onChange={(value) =>
              setSearch((now) => (value ? now.set('before', value) : now.delete('before'), now), { replace: true })
            }
            data={others.map((one) => ({
              value: one.session_id,
              label: `${dateTime(one.started_at)} · ${one.exercise_name ?? t(`walk.kind.${one.kind}`)}${one.speed_mps === null ? '' : ` · ${number(one.speed_mps, 2)} m/s`}`,
            }))}
            w={460}
            maw="100%"
          />
          <Button
            component={Link}
            variant="default"
            to={`/patients/${patient.id}/walks`}
            leftSection={<IconArrowsDiff size={18} aria-hidden />}
          >
            {t('before.conditions')}
          </Button>
        </div>
      )}
      {before.error && <Problem error={before.error} />}
      <TestResult gait={gait} />
      <MapCard gait={gait} selected={selected} />
      <WalkNumbers gait={gait} before={earlier} affected={patient?.affected_side ?? null} />
      <Curves gait={gait} before={earlier} />
      <StrideTable gait={gait} selected={selected} onSelect={setSelected} />
    </div>
  );
}

export function GaitPage() {
  const { sessionId = '' } = useParams();
  const session = useSession(sessionId);
  const gait = useGait(sessionId);
  const patient = usePatient(session.data?.patient_id ?? '');
  const name = patient.data ? fullName(patient.data) : '';
  const started = session.data?.started_at ?? session.data?.created_at;
  return (
    <Page
      compact
      title={session.data?.exercise_name ?? t('walk.title')}
      lead={session.data && started ? `${name} · ${dateTime(started)}` : undefined}
      crumbs={patientCrumbs(session.data?.patient_id, name)}
      actions={
        <>
          <Button
            component={Link}
            variant="default"
            to={`/sessions/${sessionId}`}
            leftSection={<IconCube size={18} aria-hidden />}
          >
            {t('walk.replay')}
          </Button>
          <Button
            component={Link}
            variant="default"
            to={`/sessions/${sessionId}/report`}
            leftSection={<IconFileText size={18} aria-hidden />}
          >
            {t('report.open')}
          </Button>
        </>
      }
    >
      <QueryBoundary of={gait} lines={8} height={50}>
        {(data) => <Loaded key={data.session_id} gait={data} patient={patient.data} />}
      </QueryBoundary>
    </Page>
  );
}
