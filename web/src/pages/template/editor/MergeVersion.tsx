// A version that somebody saved while this one was drawn on: joined with it, field by field.
import { useMemo } from 'react';
import { useTemplateVersion } from '../../../api/queries';
import type { CueDesign, KnotDesign, StopDesign, TemplateVersionDetail } from '../../../api/types';
import { Answer } from '../../../components/Feedback';
import { MergeCard, type MergeWords } from '../../../components/forms/MergeCard';
import { t } from '../../../i18n';
import { channelLabel } from '../../../lib/channels';
import { bandsFor, designOf, draftOf, stretches, type Draft } from '../../../lib/assessment/design';
import { designFields, designOfFields } from '../../../lib/editing/designFields';
import { merge } from '../../../lib/editing/merge';
import { number, quantity } from '../../../lib/format';
import { cueSays, cueWhen, phaseName, unitOf } from './words';

const MINUTE_S = 60;
/** What follows the first colon, without which of several alike it is. */
const after = (name: string) => name.slice(name.indexOf(':') + 1).replace(/#\d+$/, '');

function stopText(one: StopDesign): string {
  const limit = one.limit ?? 0;
  if (one.kind === 'limit') return quantity(limit, unitOf(one.channel ?? ''));
  if (one.kind === 'time')
    return t('meanwhile.minutes', { minutes: number(limit / MINUTE_S, limit % MINUTE_S ? 1 : 0) });
  if (one.kind === 'lost' || one.kind === 'unsure') return quantity(one.hold_s, 's');
  return number(limit);
}

function stopName(field: string): string {
  const [kind = '', channel = '', side = ''] = after(field).split('|');
  if (kind === 'limit')
    return t(side === 'below' ? 'meanwhile.limitbelow' : 'meanwhile.limitabove', { curve: channelLabel(channel).text });
  if (kind === 'lost' || kind === 'unsure') return t(`meanwhile.stop.${kind}`);
  return t(`design.stop.${kind as 'valid_count' | 'attempt_count' | 'time' | 'wrong_in_a_row'}`);
}

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
      const name = after(field);
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
      if (field.startsWith('band:')) return bandText(after(field), value as KnotDesign[], drafts[whose]);
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
    <Answer of={newest} lines={3}>
      {(found) => <Joined key={found.id} base={base} draft={draft} newest={found} onTake={onTake} />}
    </Answer>
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
    const fields = (one: Draft) => designFields(designOf(one));
    return merge(fields(drafts.before), fields(drafts.mine), fields(drafts.theirs));
  }, [drafts]);
  return (
    <MergeCard
      merge={joined}
      words={wordsOfFields(drafts, newest.content.measures)}
      name={newest.made_by}
      at={newest.created_at}
      saved={(when) => t('meanwhile.savedVersion', { name: newest.made_by, number: newest.number, when })}
      notes={[
        ...(newest.reason ? [t('meanwhile.reason', { reason: newest.reason })] : []),
        ...(newest.source_session_id === base.source_session_id ? [] : [t('meanwhile.recorded')]),
      ]}
      onTake={(fields) => onTake(newest, draftOf(designOfFields(fields, designOf(drafts.theirs))))}
    />
  );
}
