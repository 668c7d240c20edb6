import { Button, Modal } from '@mantine/core';
import { useDisclosure } from '@mantine/hooks';
import { IconRouteOff } from '@tabler/icons-react';
import { Link, useParams, useSearchParams } from 'react-router';
import { useExercises, usePatient, useTemplates } from '../api/queries';
import { QueryBoundary, Empty, Problem } from '../components/Feedback';
import { Page } from '../components/Page';
import { isWalk } from '../lib/exercises';
import { t } from '../i18n';
import { channelLabel } from '../lib/channels';
import { fullName } from '../lib/people';
import { EditExercise } from './EditExercise';
import { TemplateCard } from './template/TemplateCard';

export function ExercisePage() {
  const { exerciseId = '' } = useParams();
  const [search] = useSearchParams();
  const exercises = useExercises();
  const patientId = search.get('patient');
  const templates = useTemplates(exerciseId, patientId, true, search.has('retired'));
  const patient = usePatient(patientId ?? '');
  const [isEdited, dialog] = useDisclosure(false);
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
        ...(patient.data ? [{ to: `/patients/${patient.data.id}`, text: fullName(patient.data) }] : []),
      ]}
      actions={
        <>
          {exercise && (
            <Button variant="default" onClick={dialog.open}>
              {t('exercise.edit')}
            </Button>
          )}
          <Button
            component={Link}
            to={`/templates/record?exercise=${exerciseId}${patientId ? `&patient=${patientId}` : ''}`}
          >
            {t('template.record')}
          </Button>
        </>
      }
    >
      {exercises.error && <Problem error={exercises.error} />}
      <div className="stack">
        <QueryBoundary of={templates} lines={6} height={44}>
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
        </QueryBoundary>
      </div>
      <Modal
        opened={isEdited}
        onClose={dialog.close}
        title={t('exercise.edit')}
        closeButtonProps={{ 'aria-label': t('action.close') }}
      >
        {isEdited && exercise && <EditExercise exercise={exercise} onDone={dialog.close} />}
      </Modal>
    </Page>
  );
}
