// A version that somebody saved while this one was drawn on: joined with it, field by field.
import { useMemo } from 'react';
import { useTemplates, useTemplateVersion } from '../../../api/queries';
import type { CueDesign, KnotDesign, StopDesign, TemplateVersionDetail } from '../../../api/types';
import { QueryBoundary } from '../../../components/Feedback';
import { MergeCard, type MergeWords } from '../../../components/forms/MergeCard';
import { t } from '../../../i18n';
import { channelLabel } from '../../../lib/channels';
import { bandsFor, designOf, draftOf, stretches, type Draft } from '../../../lib/assessment/design';
import { designFields, designOfFields, subjectOf } from '../../../lib/editing/designFields';
import { merge } from '../../../lib/editing/merge';
import { number, quantity } from '../../../lib/format';
import { cueSays, cueWhen, namesOf, phaseName, removedStops, stopName, stopText } from './words';

function cueText(cue: CueDesign): string {
  const says = cue.is_on === false ? `${cueSays(cue)} (${t('meanwhile.off')})` : cueSays(cue);
  return `“${says}”`;
}

function bandText(channel: string, knots: KnotDesign[], draft: Draft): string {
  const factor = (value: number | null) =>
    value === null ? t('design.free') : t('meanwhile.ofRecorded', { percent: number(100 * value) });
  // By the phases of its own state, as the person saw it who drew it.
  const own: Draft = { ...draft, bands: {}, loose: { [channel]: knots } };
  const parts = bandsFor(own, channel).map((band, index) =>
    t('meanwhile.band', {
      phase: phaseName(draft.phases, index),
      below: factor(band.below),
      above: factor(band.above),
    }),
  );
  return `${parts.join('; ')} (${t('meanwhile.bandHelp')})`;
}

function phasesText(draft: Draft): string {
  return stretches(draft.phases)
    .map(([, end], index) =>
      t('meanwhile.phase', { phase: phaseName(draft.phases, index), percent: number(100 * end) }),
    )
    .join(', ');
}

const PACE: Record<string, () => string> = {
  'pace:silence_s': () => t('design.silence'),
  'pace:praise_every': () => t('design.praise'),
  'pace:cue_every': () => t('design.every'),
  valid_share: () => t('design.validShare'),
  phases: () => t('design.phases'),
};

/** Fields of a design in words, with the cues and measures of the states that are joined. */
function wordsOfFields(
  drafts: Record<'mine' | 'theirs' | 'before', Draft>,
  measures: TemplateVersionDetail['content']['measures'],
): MergeWords {
  const cues = Object.values(drafts).flatMap((one) => one.cues);
  return {
    label: (field) => {
      const fixed = PACE[field];
      if (fixed) return fixed();
      const name = subjectOf(field);
      if (field.startsWith('stop:')) return stopName(field);
      if (field.startsWith('cue:')) {
        const cue = cues.find((one) => `cue:${name}` in designFields({ cues: [one] }));
        return cue ? t('meanwhile.cue', { what: cueWhen(cue) }) : t('design.cues');
      }
      if (field.startsWith('weight:'))
        return `${t('design.weight')}: ${measures?.find((one) => one.measure === name)?.label ?? name}`;
      const curve = channelLabel(name).text;
      return field.startsWith('band:') ? t('meanwhile.bandOf', { curve }) : curve;
    },
    value: (field, value, whose) => {
      if (field === 'phases') return phasesText(drafts[whose]);
      if (field.startsWith('watched:')) return t(value ? 'design.isWatched' : 'design.counts');
      if (field.startsWith('band:') && value === undefined) return t('design.isRecorded');
      if (field.startsWith('band:')) return bandText(subjectOf(field), value as KnotDesign[], drafts[whose]);
      if (value === undefined || value === null) return t('meanwhile.none');
      if (field.startsWith('stop:')) return stopText(value as StopDesign);
      if (field.startsWith('cue:')) return cueText(value as CueDesign);
      if (field === 'valid_share') return `${number(100 * (value as number))} %`;
      if (field === 'pace:silence_s') return quantity(value as number, 's');
      return String(value);
    },
  };
}

export function MergeVersion({
  base,
  draft,
  newestId,
  onTake,
}: {
  base: TemplateVersionDetail;
  draft: Draft;
  /** The version that is stored now. */
  newestId: string;
  onTake: (newest: TemplateVersionDetail, merged: Draft) => void;
}) {
  const newest = useTemplateVersion(newestId);
  return (
    <QueryBoundary of={newest} lines={3}>
      {(found) => <Joined key={found.id} base={base} draft={draft} newest={found} onTake={onTake} />}
    </QueryBoundary>
  );
}

/** All versions that were saved since one was opened, the oldest first; null while they are not known. */
function useVersionsBetween(base: TemplateVersionDetail, newest: TemplateVersionDetail) {
  const isOnly = newest.number === base.number + 1;
  const templates = useTemplates(newest.exercise_id, newest.patient_id, !isOnly, true);
  if (isOnly) return [newest];
  const versions = templates.data?.find((one) => one.id === newest.template_id)?.versions;
  return (
    versions
      ?.filter((one) => one.number > base.number && one.number <= newest.number)
      .sort((one, other) => one.number - other.number) ?? null
  );
}

function Joined({
  base,
  draft,
  newest,
  onTake,
}: {
  base: TemplateVersionDetail;
  draft: Draft;
  newest: TemplateVersionDetail;
  onTake: (newest: TemplateVersionDetail, merged: Draft) => void;
}) {
  const drafts = useMemo(
    () => ({ before: draftOf(base.design), mine: draft, theirs: draftOf(newest.design) }),
    [base, draft, newest],
  );
  const joined = useMemo(() => {
    const opened = designOf(drafts.before);
    const fields = (one: Draft) => designFields(designOf(one), opened);
    return merge(fields(drafts.before), fields(drafts.mine), fields(drafts.theirs));
  }, [drafts]);
  const between = useVersionsBetween(base, newest);
  const name = between ? namesOf(between.map((one) => one.made_by)) : t('meanwhile.several');
  return (
    <MergeCard
      merge={joined}
      words={wordsOfFields(drafts, newest.content.measures)}
      name={name}
      at={newest.created_at}
      saved={(when) =>
        newest.number - base.number > 1
          ? t('meanwhile.savedVersions', { name, first: base.number + 1, last: newest.number, when })
          : t('meanwhile.savedVersion', { name, number: newest.number, when })
      }
      notes={[
        ...(between ?? [newest]).flatMap(({ reason }) => (reason ? [t('meanwhile.reason', { reason })] : [])),
        ...removedStops(joined),
        ...(newest.source_session_id === base.source_session_id ? [] : [t('meanwhile.recorded')]),
      ]}
      onTake={(fields) => onTake(newest, draftOf(designOfFields(fields, designOf(drafts.theirs))))}
    />
  );
}
