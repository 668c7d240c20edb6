// A template as an instrument: the therapist draws what matters on the recorded curves, and saves it as the next version.
import { Button, Group, Textarea } from '@mantine/core';
import { useMemo, useState } from 'react';
import { useNavigate, useParams } from 'react-router';
import { LegendRow, LegendStroke } from '../../../charts/Legend';
import { ApiError } from '../../../api/client';
import { useDrawVersion } from '../../../api/changes';
import { useTemplateVersion } from '../../../api/queries';
import type { TemplateVersionDetail } from '../../../api/types';
import { QueryBoundary, Notice, Problem } from '../../../components/Feedback';
import { useUnsaved } from '../../../components/forms/useUnsaved';
import { Page } from '../../../components/Page';
import { t } from '../../../i18n';
import {
  designOf,
  draftOf,
  suggestedBorders,
  withBand,
  withBorder,
  withoutPhase,
  withPhases,
  withSplit,
  type Draft,
} from '../../../lib/assessment/design';
import { pickCurves } from '../../../lib/assessment/comparison';
import { brokenBy } from '../../../lib/assessment/limits';
import { bodyLength, date } from '../../../lib/format';
import { limbOf } from '../../../lib/placements';
import '../../../styles/design.css';
import { BandChart } from './BandChart';
import { CueRules } from './CueRules';
import { CurveList } from './CurveList';
import { MergeVersion } from './MergeVersion';
import { PhaseTable } from './PhaseTable';
import { StopRules } from './StopRules';
import { Weights } from './Weights';
import './EditTemplate.css';
import './editor.css';

function suggested(draft: Draft, mean: readonly (number | null)[]): Draft {
  const borders = suggestedBorders(mean);
  const names =
    borders.length === 1
      ? [t('design.suggestedOut'), t('design.suggestedBack')]
      : [t('design.suggestedOut'), t('design.suggestedHold'), t('design.suggestedBack')];
  return withPhases(
    draft,
    names.map((name, index) => ({ name, end: borders[index] ?? 1 })),
    () => 0,
  );
}

/** Whether somebody can follow it live, with cues and stops; strides are compared afterwards only. */
const isGuided = (version: TemplateVersionDetail) => version.is_guided !== false;

/** The curve with its phases, and the list of curves beside it. */
function Drawing({
  version,
  draft,
  onDraft,
}: {
  version: TemplateVersionDetail;
  draft: Draft;
  onDraft: (change: (now: Draft) => Draft) => void;
}) {
  const { curves, repetitions } = version.content;
  const [channel, setChannel] = useState(version.primary_channel);
  const [selected, setSelected] = useState(0);
  const left = useMemo(() => new Set(repetitions.flatMap((one, index) => (one.is_kept ? [] : [index]))), [repetitions]);
  const curve = curves.find((one) => one.channel === channel) ?? pickCurves(curves, true, version.primary_channel)[0];
  if (!curve) return null;
  const main = curves.find((one) => one.channel === version.primary_channel) ?? curve;
  const phase = Math.min(selected, draft.phases.length - 1);
  return (
    <section className="card" aria-label={curve.label}>
      <div className="design-drawing">
        <CurveList
          curves={curves}
          primary={version.primary_channel}
          draft={draft}
          selected={curve.channel}
          onSelect={setChannel}
          onWatched={(name, isWatched) =>
            onDraft((now) => ({
              ...now,
              watched: isWatched ? [...now.watched, name] : now.watched.filter((one) => one !== name),
            }))
          }
        />
        <div className="design-curve">
          <div className="card-head">
            <h2>{curve.label}</h2>
          </div>
          <Legend />
          <BandChart
            curve={curve}
            draft={draft}
            left={left}
            selected={phase}
            onSelect={setSelected}
            onBand={(at, edge, factor) => onDraft((now) => withBand(now, curve.channel, at, edge, factor))}
            onBorder={(at, end) => onDraft((now) => withBorder(now, at, end))}
          />
          <p className="muted small">{t('design.help')}</p>
          <PhaseTable
            curve={curve}
            draft={draft}
            selected={phase}
            onSelect={setSelected}
            onBand={(at, edge, factor) => onDraft((now) => withBand(now, curve.channel, at, edge, factor))}
            onName={(at, name) =>
              onDraft((now) => ({
                ...now,
                phases: now.phases.map((one, index) => (index === at ? { ...one, name } : one)),
              }))
            }
            onSplit={(at) =>
              onDraft((now) => withSplit(now, at, t('design.phaseNumber', { number: now.phases.length + 1 })))
            }
            onRemove={(at) => onDraft((now) => withoutPhase(now, at))}
            onSuggest={isGuided(version) ? () => onDraft((now) => suggested(now, main.mean)) : undefined}
          />
          {/* Of a leg no positions are compared, which a reach would scale. */}
          {limbOf(version.primary_channel) === 'arm' && (
            <p className="muted small">{t('design.scaled', { reach: bodyLength(version.reach_m) })}</p>
          )}
        </div>
      </div>
    </section>
  );
}

function Legend() {
  return (
    <ul className="legend plain-list">
      <LegendRow sign={<rect width="34" height="14" rx="3" className="band-area" />}>
        {t('design.legendBand')}
      </LegendRow>
      <LegendStroke className="band-mean">{t('design.legendMean')}</LegendStroke>
      <LegendStroke className="band-repetition">{t('design.legendRepetition')}</LegendStroke>
    </ul>
  );
}

/** The version that is stored now, where the service refused to save on top of an older one. */
function newerThan(error: unknown): string | null {
  const newest = error instanceof ApiError && error.status === 409 ? error.details.newest : null;
  return typeof newest === 'string' ? newest : null;
}

function Editor({
  opened,
  onSaved,
}: {
  opened: TemplateVersionDetail;
  onSaved: (made: TemplateVersionDetail) => void;
}) {
  // Another one once somebody saved meanwhile and both changes were joined.
  const [version, setVersion] = useState(opened);
  const start = useMemo(() => draftOf(version.design), [version]);
  const [draft, setDraft] = useState(start);
  const [reason, setReason] = useState('');
  const [isJoined, setJoined] = useState(false);
  const isChanged = JSON.stringify(designOf(draft)) !== JSON.stringify(designOf(start));
  // What a restored draft was drawn on, where that is not the version that is open: fetched first.
  const [baseId, setBaseId] = useState<string | null>(null);
  const base = useTemplateVersion(baseId);
  const [aheadId, setAheadId] = useState<string | null>(null);
  const { guard, release } = useUnsaved({
    object: `template:${opened.template_id}`,
    value: { draft, reason, basedOn: baseId ?? version.id },
    isChanged: isChanged || reason.trim() !== '' || baseId !== null,
    onRestore: (stored) => {
      setDraft(stored.draft);
      setReason(stored.reason);
      if (stored.basedOn !== version.id) setBaseId(stored.basedOn);
    },
  });
  if (base.data && base.data.id === baseId) {
    setBaseId(null);
    setVersion(base.data);
    // Joined before anything is saved; on the page of an old version the draft is the newer of the two.
    setAheadId(base.data.number < opened.number ? opened.id : null);
  }
  const save = useDrawVersion(version.template_id, release);
  const newestId = newerThan(save.error) ?? aheadId;
  const { curves, repetitions } = version.content;
  const left = useMemo(() => new Set(repetitions.flatMap((one, index) => (one.is_kept ? [] : [index]))), [repetitions]);
  const isBroken = draft.stops.some((one) => brokenBy(one, curves, left));
  const angles = pickCurves(curves, true, version.primary_channel).filter((one) => !one.channel.includes('.'));
  return (
    <div className="stack">
      {guard}
      <p className="muted">
        {t('design.basedOn', { number: version.number, date: date(version.created_at), by: version.made_by })}
        {version.reason && ` · ${version.reason}`}
      </p>
      {(version.troubles ?? []).map((one) => (
        <Notice key={one}>{one}</Notice>
      ))}
      <Drawing version={version} draft={draft} onDraft={(change) => setDraft(change)} />
      {isGuided(version) && (
        <>
          <StopRules
            stops={draft.stops}
            curves={curves}
            left={left}
            channels={angles.map((one) => one.channel)}
            primary={version.primary_channel}
            onChange={(stops) => setDraft((now) => ({ ...now, stops }))}
          />
          <CueRules draft={draft} curves={angles} onChange={(change) => setDraft((now) => ({ ...now, ...change }))} />
        </>
      )}
      <Weights
        weights={draft.weights}
        measures={version.content.measures ?? []}
        onChange={(weights) => setDraft((now) => ({ ...now, weights }))}
      />
      <form
        className="card stack"
        aria-labelledby="save"
        onSubmit={(event) => {
          event.preventDefault();
          save.mutate({ based_on: version.id, design: designOf(draft), reason: reason.trim() }, { onSuccess: onSaved });
        }}
      >
        <h2 id="save">{t('design.saveTitle')}</h2>
        <Textarea
          label={t('design.reason')}
          description={t('design.reasonHelp')}
          placeholder={t('design.reasonExample')}
          autosize
          minRows={2}
          maxLength={500}
          maw={640}
          value={reason}
          onChange={(event) => setReason(event.currentTarget.value)}
        />
        {save.error && !newestId && <Problem error={save.error} />}
        {base.error && <Problem error={base.error} onRetry={() => void base.refetch()} />}
        {newestId && (
          <MergeVersion
            base={version}
            draft={draft}
            newestId={newestId}
            onTake={(newest, merged) => {
              setVersion(newest);
              setDraft(merged);
              setAheadId(null);
              setJoined(true);
              save.reset();
            }}
          />
        )}
        {isJoined && !newestId && <Notice>{t('meanwhile.taken')}</Notice>}
        <Group>
          <Button
            type="submit"
            size="lg"
            disabled={!isChanged || !reason.trim() || isBroken || newestId !== null || baseId !== null}
            loading={save.isPending}
          >
            {t('design.save', { number: version.number + 1 })}
          </Button>
          {isChanged && (
            <Button variant="default" size="lg" onClick={() => setDraft(start)}>
              {t('design.undo')}
            </Button>
          )}
        </Group>
        <p className={isBroken ? 'problem' : 'muted small'} role={isBroken ? 'alert' : undefined}>
          {t(isBroken ? 'design.limitBroken' : isChanged ? 'design.saved' : 'design.unchanged')}
        </p>
      </form>
    </div>
  );
}

export function EditTemplatePage() {
  const { versionId = '' } = useParams();
  const navigate = useNavigate();
  const version = useTemplateVersion(versionId);
  const found = version.data;
  return (
    <Page
      title={found ? t('design.title', { name: found.name }) : t('design.open')}
      lead={t(found && !isGuided(found) ? 'design.walkLead' : 'design.lead')}
      crumbs={[
        { to: '/exercises', text: t('nav.exercises') },
        ...(found ? [{ to: exercisePath(found), text: found.name }] : []),
      ]}
    >
      <QueryBoundary of={version} lines={8} height={44}>
        {(data) => <Editor key={data.id} opened={data} onSaved={(made) => void navigate(exercisePath(made))} />}
      </QueryBoundary>
    </Page>
  );
}

function exercisePath(version: TemplateVersionDetail): string {
  return `/exercises/${version.exercise_id}?version=${version.id}${version.patient_id ? `&patient=${version.patient_id}` : ''}`;
}
