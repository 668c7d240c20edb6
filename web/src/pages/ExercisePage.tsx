import { Button, Select } from '@mantine/core';
import { IconPencil, IconRouteOff } from '@tabler/icons-react';
import { useState } from 'react';
import { Link, useParams, useSearchParams } from 'react-router';
import { useExercises, usePatient, useTemplates, useTemplateVersion } from '../api/queries';
import type { Template } from '../api/types';
import { PhaseChart, PhaseLegend } from '../charts/PhaseChart';
import { Answer, Empty, Problem } from '../components/Feedback';
import { Page } from '../components/Page';
import { isWalk } from '../lib/exercises';
import { t } from '../i18n';
import { channelLabel } from '../lib/channels';
import { pickCurves } from '../lib/assessment/comparison';
import { date, number } from '../lib/format';

function TemplateCard({
  template,
  wanted,
  primary,
}: {
  template: Template;
  wanted: string | null;
  primary: string | null;
}) {
  const [picked, setPicked] = useState<string | null>(null);
  const versionId =
    picked ?? template.versions.find((one) => one.id === wanted)?.id ?? template.versions[0]?.id ?? null;
  const version = useTemplateVersion(versionId);
  return (
    <section className="card" aria-label={template.name}>
      <div className="card-head">
        <h2>{template.name}</h2>
        <span className="tag">{template.patient_id ? t('template.onePatient') : t('template.wholeClinic')}</span>
        {template.versions.length > 1 && (
          <Select
            className="end"
            size="sm"
            w={230}
            aria-label={t('template.versionLabel')}
            data={template.versions.map((one) => ({
              value: one.id,
              label: t('template.versionOf', { number: one.number, date: date(one.created_at) }),
            }))}
            value={versionId}
            onChange={setPicked}
          />
        )}
      </div>
      <Answer of={version} lines={4} height={40}>
        {({ id, content, repetition_count: count, number: versionNumber, created_at: at, reason, made_by: madeBy }) => (
          <>
            <p className="muted small">
              {t('template.made', {
                number: versionNumber,
                date: date(at),
                count,
                seconds: number(content.duration_s, 1),
              })}
            </p>
            {reason && <p className="small">{t('template.why', { by: madeBy, reason })}</p>}
            <div>
              <Button
                component={Link}
                to={`/templates/versions/${id}`}
                leftSection={<IconPencil size={18} aria-hidden />}
              >
                {t('design.open')}
              </Button>
            </div>
            <PhaseLegend withOutside={false} patient={false} />
            <div className="template-curves">
              {pickCurves(content.curves, false, primary).map((curve) => (
                <div key={curve.channel} className="template-curve">
                  <h3>{curve.label}</h3>
                  <PhaseChart
                    curve={curve}
                    left={new Set(content.repetitions.flatMap((one, index) => (one.is_kept ? [] : [index])))}
                    height={200}
                  />
                </div>
              ))}
            </div>
          </>
        )}
      </Answer>
    </section>
  );
}

export function ExercisePage() {
  const { exerciseId = '' } = useParams();
  const [search] = useSearchParams();
  const exercises = useExercises();
  const patientId = search.get('patient');
  const templates = useTemplates(exerciseId, patientId);
  const patient = usePatient(patientId ?? '');
  const exercise = exercises.data?.find((one) => one.id === exerciseId);
  return (
    <Page
      title={exercise?.name ?? t('exercise.one')}
      lead={
        exercise &&
        (exercise.description ||
          (isWalk(exercise.movement)
            ? t('exercise.judgedByWalk')
            : t('exercise.judgedBy', { angle: channelLabel(exercise.primary_angle ?? '').text })))
      }
      crumbs={[
        { to: '/exercises', text: t('nav.exercises') },
        ...(patient.data
          ? [{ to: `/patients/${patient.data.id}`, text: `${patient.data.given_name} ${patient.data.family_name}` }]
          : []),
      ]}
      actions={
        <Button
          component={Link}
          to={`/templates/record?exercise=${exerciseId}${patientId ? `&patient=${patientId}` : ''}`}
        >
          {t('template.record')}
        </Button>
      }
    >
      {exercises.error && <Problem error={exercises.error} />}
      <div className="stack">
        <Answer of={templates} lines={6} height={44}>
          {(list) =>
            list.length === 0 ? (
              <div className="card">
                <Empty
                  icon={<IconRouteOff size={44} aria-hidden />}
                  title={patientId ? t('template.emptyTitle') : t('template.emptyClinicTitle')}
                >
                  {patientId ? t('template.emptyText') : t('template.emptyClinicText')}
                </Empty>
              </div>
            ) : (
              list.map((one) => (
                <TemplateCard
                  key={one.id}
                  template={one}
                  wanted={search.get('version')}
                  primary={exercise?.primary_angle ?? null}
                />
              ))
            )
          }
        </Answer>
      </div>
    </Page>
  );
}
