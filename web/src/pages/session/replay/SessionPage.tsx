// Replay and compare on one page: the 3D and the time line stay, the words and curves beside them say what differs.
import { Select, Switch, Tabs } from '@mantine/core';
import { useCallback, useEffect, useMemo, useRef, useState } from 'react';
import { Navigate, useParams, useSearchParams } from 'react-router';
import {
  useComparison,
  useComparisons,
  useEstimators,
  useExercises,
  useMarkers,
  usePatient,
  useSession,
  useTemplateVersion,
} from '../../../api/queries';
import type { ComparisonDetail, Repetition, SessionDetail } from '../../../api/types';
import { Traces } from '../../../charts/Traces';
import { ChannelPicker } from '../../../components/forms/ChannelPicker';
import { QueryBoundary, Notice, Problem } from '../../../components/Feedback';
import { Page } from '../../../components/Page';
import { Timeline } from '../../../components/Timeline';
import { Viewer3D } from '../../../components/Viewer3D';
import { t } from '../../../i18n';
import { kindOf, nearOf } from '../../../kinds';
import { panelsOf } from '../../../kinds/panels';
import { preferredAngles } from '../../../lib/channels';
import { dateTime, duration } from '../../../lib/format';
import { massChannels } from '../../../lib/assessment/massCentre';
import { isOfStrides } from '../../../lib/assessment/comparison';
import { templateOver } from '../../../lib/assessment/overlay';
import { fullName, patientCrumbs } from '../../../lib/people';
import { isLive, sessionTitle } from '../../../lib/sessions';
import { useKeys } from '../../../lib/browser/keys';
import { templatePhaseAt, timeAtTemplatePhase } from '../../../lib/assessment/warp';
import { useReplayPlayer, useSnapshot } from '../../../player/hooks';
import type { ReplayPlayer } from '../../../player/replay';
import type { PlayerState } from '../../../api/types';
import { ComparisonPanel } from './ComparisonPanel';
import { DetailsPanel, resultLabel } from './DetailsPanel';
import { Said } from './Said';
import { SlippedSensors } from './SlippedSensors';
import { SessionWorries, useSessionWorries } from './SessionWorries';
import { MarkerLegend, MarkerMotion } from './MarkerMotion';
import { MarkersPanel } from './MarkersPanel';
import { MassPanel } from './MassPanel';
import { RepetitionTable } from './RepetitionTable';
import './SessionPage.css';
import './replay.css';

interface ReplayProps {
  session: SessionDetail;
  player: ReplayPlayer;
  resultId: string;
  comparison: ComparisonDetail | null;
  hasComparison: boolean;
}

function Replay({ session, player, resultId, comparison, hasComparison }: ReplayProps) {
  const [search, setSearch] = useSearchParams();
  const snapshot = useSnapshot(player);
  const exercises = useExercises();
  const exercise = exercises.data?.find((one) => one.id === session.exercise_id);
  const template = useTemplateVersion(comparison?.template_version_id ?? null);
  const [ghost, setGhost] = useState({ ghost: true, warp: true });
  const [shown, setShown] = useState<PlayerState | null>(null);
  const [selected, setSelected] = useState<number | null>(null);
  const [chosen, setChosen] = useState<string[] | null>(null);
  const stage = useRef<HTMLDivElement>(null);
  const angles = snapshot.columns?.layout.angles ?? session.layout.angles;
  const channels = useMemo(
    () =>
      (chosen ?? preferredAngles(angles, exercise?.primary_angle, exercise?.side ?? null)).filter((name) =>
        angles.includes(name),
      ),
    [chosen, angles, exercise],
  );
  const mass = useMemo(
    () => massChannels(snapshot.columns?.layout.scalars ?? session.layout.scalars),
    [snapshot.columns, session.layout.scalars],
  );
  const repetitions = useMemo(() => comparison?.repetitions.map((one) => one.repetition) ?? [], [comparison]);
  const compared = useMemo(() => comparison?.curves.map((one) => one.channel) ?? [], [comparison]);
  const templateAt = useMemo(
    () =>
      comparison && ghost.ghost
        ? templateOver(comparison, template.data?.content.duration_s ?? null, ghost.warp)
        : undefined,
    [comparison, template.data, ghost],
  );
  const seek = useCallback((sinceStartS: number) => player.seek(player.clock().startS + sinceStartS), [player]);

  // An address with a moment in it opens at that moment.
  const wanted = search.get('t');
  const isOpen = snapshot.connection === 'open';
  useEffect(() => {
    if (wanted !== null && isOpen) player.seek(Number(wanted));
  }, [wanted, isOpen, player]);

  const jumpTo = (repetition: number, templatePhase: number) => {
    const found = comparison?.repetitions[repetition];
    if (!found) return;
    setSelected(repetition);
    player.pause();
    player.seek(timeAtTemplatePhase(found.repetition, found.warp_template_phase, templatePhase));
    stage.current?.scrollIntoView({ block: 'nearest' });
  };
  const choose = (repetition: Repetition) => setSelected(repetitions.indexOf(repetition));

  useKeys({
    ' ': () => (player.clock().isPlaying ? player.pause() : player.play()),
    // Without a figure its switches are not there, and nobody could bring back what a key took away.
    ...(shown?.has_ghost !== false && {
      w: () => setGhost((now) => ({ ...now, warp: !now.warp })),
      g: () => setGhost((now) => ({ ...now, ghost: !now.ghost })),
    }),
  });
  const phaseNow = useCallback(
    () => (comparison ? templatePhaseAt(comparison.repetitions, player.clock().timeS) : null),
    [comparison, player],
  );
  const kind = kindOf(session);
  const isHurt = useSessionWorries(session).some((one) => one.kind === 'pain');
  const { UnderPicture, tab: own, angles: angleTitle, Curves } = panelsOf(session).replay;
  const hasCompare = kind.isCompared;
  const markers = useMarkers(session.id);
  const fused = useMemo(() => (markers.data ?? []).filter((one) => one.report !== null), [markers.data]);
  const marker = fused.find((one) => one.id === search.get('markers')) ?? fused[0] ?? null;
  const asked = search.get('show') ?? own?.value ?? (hasComparison ? 'compare' : angleTitle ? 'angles' : 'details');
  // A link to markers waits for them; when there are none it shows where they are added.
  const tab = asked === 'markers' && markers.data && !marker ? 'details' : asked;
  const marked = tab === 'markers' ? marker : null;
  const isWaiting = tab === 'markers' && markers.isPending;
  return (
    <>
      {snapshot.problem && <Problem error={new Error(snapshot.problem)} title={t('replay.failed')} />}
      <div className="stack replay-first">
        <SessionWorries session={session} />
        <SlippedSensors session={session} />
        {isHurt && <Said session={session} />}
      </div>
      <div className="replay-grid" role="group" aria-label={t('replay.title')}>
        <div className="stage" ref={stage}>
          <Viewer3D
            sessionId={session.id}
            request={{
              mode: 'replay',
              result_id: resultId,
              template_version_id: comparison?.template_version_id ?? null,
              markers_id: marked?.id ?? null,
            }}
            title={t(marked ? 'markers.viewer' : 'viewer.replayTitle')}
            near={marked ? 'marker' : nearOf(session)}
            isReady={!isWaiting}
            player={player}
            ghost={ghost}
            onShown={setShown}
          />
          <Timeline
            player={player}
            repetitions={repetitions}
            events={session.events}
            onRepetition={choose}
            areStrides={isOfStrides(comparison)}
          />
          {marked ? <MarkerLegend /> : UnderPicture && <UnderPicture session={session} />}
          {comparison && !marked && shown?.has_ghost !== false && (
            <div className="ghost-tools">
              <Switch
                label={t('replay.ghost')}
                checked={ghost.ghost}
                onChange={(event) => setGhost({ ...ghost, ghost: event.currentTarget.checked })}
              />
              <Switch
                label={t('replay.warp')}
                checked={ghost.warp}
                disabled={!ghost.ghost || shown?.has_warp === false}
                onChange={(event) => setGhost({ ...ghost, warp: event.currentTarget.checked })}
              />
              <span className="muted small for-keys">{t('replay.keys')}</span>
            </div>
          )}
        </div>
        <Tabs
          className="side-tabs"
          value={tab}
          onChange={(value) => setSearch((now) => (now.set('show', value ?? 'angles'), now), { replace: true })}
          keepMounted={false}
        >
          <Tabs.List aria-label={t('replay.tabs')}>
            {own && <Tabs.Tab value={own.value}>{own.title()}</Tabs.Tab>}
            {hasCompare && <Tabs.Tab value="compare">{t('compare.title')}</Tabs.Tab>}
            {angleTitle && <Tabs.Tab value="angles">{angleTitle()}</Tabs.Tab>}
            {mass.length > 0 && <Tabs.Tab value="mass">{t('mass.title')}</Tabs.Tab>}
            {marker && <Tabs.Tab value="markers">{t('markers.title')}</Tabs.Tab>}
            <Tabs.Tab value="details">{t('details.title')}</Tabs.Tab>
          </Tabs.List>
          {own && (
            <Tabs.Panel value={own.value}>
              <own.Panel session={session} resultId={resultId} player={player} onSeek={seek} />
            </Tabs.Panel>
          )}
          <Tabs.Panel value="compare">
            <h2 className="visually-hidden">{t('compare.title')}</h2>
            <ComparisonPanel
              session={session}
              resultId={resultId}
              comparison={comparison}
              hasComparison={hasComparison}
              selected={selected}
              onSelect={setSelected}
              onPhase={jumpTo}
              phaseNow={phaseNow}
            />
          </Tabs.Panel>
          <Tabs.Panel value="angles">
            <h2 className="visually-hidden">{angleTitle?.()}</h2>
            {Curves ? (
              <Curves
                session={session}
                resultId={resultId}
                player={player}
                onSeek={seek}
                templateAt={templateAt}
                compared={compared}
              />
            ) : (
              <>
                <div className="card-head">
                  <p className="muted small">{comparison ? t('replay.curvesWithTemplate') : t('replay.curves')}</p>
                  <span className="end">
                    <ChannelPicker available={angles} value={channels} onChange={setChosen} />
                  </span>
                </div>
                <Traces player={player} channels={channels} templateAt={templateAt} onSeek={seek} />
              </>
            )}
          </Tabs.Panel>
          <Tabs.Panel value="mass">
            <MassPanel sessionId={session.id} resultId={resultId} player={player} channels={mass} onSeek={seek} />
          </Tabs.Panel>
          <Tabs.Panel value="markers">
            {marker && (
              <MarkerMotion
                fused={fused}
                shown={marker}
                onChoose={(id) => setSearch((now) => (now.set('markers', id), now), { replace: true })}
                player={player}
                onSeek={seek}
              />
            )}
          </Tabs.Panel>
          <Tabs.Panel value="details">
            <h2 className="visually-hidden">{t('details.title')}</h2>
            <DetailsPanel session={session} resultId={resultId} />
            <MarkersPanel session={session} />
          </Tabs.Panel>
        </Tabs>
      </div>
      <div className="stack below">
        {!isHurt && <Said session={session} />}
        {comparison && comparison.repetitions.length > 0 && (
          <RepetitionTable comparison={comparison} selected={selected} onSelect={(index) => jumpTo(index, 0)} />
        )}
      </div>
    </>
  );
}

function Loaded({ session }: { session: SessionDetail }) {
  const [search, setSearch] = useSearchParams();
  const comparisons = useComparisons(session.id);
  const estimators = useEstimators();
  const complete = session.results.filter((one) => one.status === 'complete');
  const asked = search.get('result');
  const resultId =
    complete.find((one) => one.id === asked)?.id ?? session.main_result_id ?? complete.at(-1)?.id ?? null;
  const ofResult = (comparisons.data ?? []).filter((one) => one.result_id === resultId);
  const summary = ofResult.find((one) => one.id === search.get('comparison')) ?? ofResult[0] ?? null;
  const comparison = useComparison(summary?.id ?? null);
  const startS = session.recording_start_s ?? 0;
  const endS = session.recording_end_s ?? session.duration_s;
  const player = useReplayPlayer(session.id, resultId, startS, endS);
  const isWaiting = comparisons.isPending || (summary !== null && comparison.isPending);
  const shown = complete.find((one) => one.id === resultId);
  const shownLabel = shown ? resultLabel(shown, false, estimators.data ?? []) : '';
  if (!resultId) return <Problem error={new Error(session.state_reason || t('replay.noResult'))} />;
  if (endS <= startS) return <Problem error={new Error(t('replay.nothingRecorded'))} />;
  return (
    <>
      {resultId !== session.main_result_id && session.main_result_id && (
        <Notice>{t('replay.notMain', { result: shownLabel })}</Notice>
      )}
      {ofResult.length > 1 && (
        <div className="result-choice">
          <Select
            label={t('replay.template')}
            size="sm"
            w={300}
            value={summary?.id ?? null}
            onChange={(value) => setSearch((now) => (value && now.set('comparison', value), now), { replace: true })}
            data={ofResult.map((one) => ({
              value: one.id,
              label: `${one.template_name}, ${dateTime(one.created_at)}`,
            }))}
          />
        </div>
      )}
      {comparison.error && <Problem error={comparison.error} />}
      {player && !isWaiting && (
        <Replay
          session={session}
          player={player}
          resultId={resultId}
          comparison={comparison.data ?? null}
          hasComparison={summary !== null}
        />
      )}
    </>
  );
}

export function SessionPage() {
  const { sessionId = '' } = useParams();
  const session = useSession(sessionId);
  const patient = usePatient(session.data?.patient_id ?? '');
  const name = patient.data ? fullName(patient.data) : '';
  if (session.data && (isLive(session.data.state) || session.data.state === 'closing'))
    return <Navigate to={`/sessions/${sessionId}/live`} replace />;
  const Actions = session.data && panelsOf(session.data).replay.Actions;
  const started = session.data?.started_at ?? session.data?.created_at;
  return (
    <Page
      compact
      title={session.data ? sessionTitle(session.data) : t('replay.title')}
      lead={
        session.data && started ? `${name} · ${dateTime(started)} · ${duration(session.data.duration_s)}` : undefined
      }
      crumbs={patientCrumbs(session.data?.patient_id, name)}
      actions={session.data?.state === 'analysed' && Actions ? <Actions session={session.data} /> : undefined}
    >
      <QueryBoundary of={session} lines={8} height={50}>
        {(data) => <Loaded key={data.id} session={data} />}
      </QueryBoundary>
    </Page>
  );
}
