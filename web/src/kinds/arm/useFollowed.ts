// The template that a live session is prescribed with, as its running curves are drawn beside it.
import { useMemo } from 'react';
import { usePrescriptions, useTemplates, useTemplateVersion } from '../../api/queries';
import type { TemplateAt } from '../../charts/Traces';
import { templateLive } from '../../lib/assessment/overlay';
import type { LiveProps } from '../kind';

/** What the patient follows; undefined without a prescription, without a template, and where the arm is the other one. */
export function useFollowed({ session, player, columns }: LiveProps): TemplateAt | undefined {
  const isPrescribed = Boolean(session.prescription_id);
  const prescriptions = usePrescriptions(isPrescribed ? session.patient_id : '');
  const prescribed = prescriptions.data?.find((one) => one.id === session.prescription_id);
  const templateId = prescribed?.template_id;
  const templates = useTemplates(session.exercise_id ?? null, session.patient_id, Boolean(templateId));
  const newest = templates.data?.find((one) => one.id === templateId)?.versions[0];
  const version = useTemplateVersion(newest?.id ?? null).data;
  const angles = columns?.layout.angles;
  const scale = prescribed?.tolerance_scale ?? 1;
  return useMemo(() => {
    // Of the other arm nothing would lie where it belongs: which way a trunk leans changes with the side.
    if (!version || !angles?.includes(version.primary_channel)) return undefined;
    return templateLive(version.content.curves, scale, (timeS) => player.templatePhaseAt(timeS));
  }, [version, angles, scale, player]);
}
