// The patient's own replay: the picture with play and pause, and one true sentence on what it shows.
import { Button } from '@mantine/core';
import { IconPlayerPauseFilled, IconPlayerPlayFilled, IconPlayerSkipBackFilled } from '@tabler/icons-react';
import { useState } from 'react';
import { Navigate, useParams } from 'react-router';
import { useComparisons, useExercises, useSession } from '../../api/queries';
import type { PlayerState, SessionDetail } from '../../api/types';
import { Waiting } from '../../components/Feedback';
import { Page } from '../../components/Page';
import { Viewer3D } from '../../components/Viewer3D';
import { nearOf } from '../../kinds';
import { t } from '../../i18n';
import { position, weekday } from '../../lib/format';
import { plainFeedback } from '../../lib/plain';
import { isLive } from '../../lib/sessions';
import { useClockText, useReplayPlayer, useSnapshot } from '../../player/hooks';
import type { ReplayPlayer } from '../../player/replay';
import { PlainProblem } from './PlainProblem';
import './Replay.css';

const GHOST = { ghost: true, warp: true };

/** Play, pause, back to the start, and a slider. */
function Transport({ player }: { player: ReplayPlayer }) {
  const { isPlaying } = useSnapshot(player);
  const timeS = useClockText(player);
  const { startS, endS } = player.clock();
  const play = () => {
    if (timeS >= endS - 0.05) player.seek(startS);
    player.play();
  };
  return (
    <div className="card home-transport">
      <input
        type="range"
        className="timeline-slider"
        aria-label={t('home.position')}
        aria-valuetext={position(timeS - startS, 0)}
        min={startS}
        max={endS}
        step={0.1}
        value={timeS}
        onChange={(event) => player.seek(Number(event.currentTarget.value))}
      />
      <div className="home-buttons">
        <Button
          size="xl"
          leftSection={
            isPlaying ? <IconPlayerPauseFilled size={28} aria-hidden /> : <IconPlayerPlayFilled size={28} aria-hidden />
          }
          onClick={() => (isPlaying ? player.pause() : play())}
        >
          {isPlaying ? t('home.pause') : t('home.play')}
        </Button>
        <Button
          size="xl"
          variant="default"
          leftSection={<IconPlayerSkipBackFilled size={24} aria-hidden />}
          onClick={() => player.seek(startS)}
        >
          {t('home.fromStart')}
        </Button>
      </div>
    </div>
  );
}

function Watch({ session }: { session: SessionDetail }) {
  const comparisons = useComparisons(session.id);
  const exercises = useExercises();
  const [shown, setShown] = useState<PlayerState | null>(null);
  const complete = session.results.filter((one) => one.status === 'complete');
  const resultId = session.main_result_id ?? complete.at(-1)?.id ?? null;
  const startS = session.recording_start_s ?? 0;
  const endS = session.recording_end_s ?? session.duration_s;
  const player = useReplayPlayer(session.id, resultId, startS, endS);
  if (!resultId || endS <= startS) return <p className="card">{t('home.nothingToShow')}</p>;
  if (!player || comparisons.isPending || exercises.isPending) return <Waiting lines={6} height={50} />;
  const comparison = comparisons.data?.find((one) => one.result_id === resultId) ?? null;
  const primary = exercises.data?.find((one) => one.id === session.exercise_id)?.primary_angle;
  const said = comparison
    ? plainFeedback(comparison.summary, comparison.repetition_count, primary)
    : [t('home.recorded')];
  return (
    <div className="stack">
      <section className="card">
        <p className="mine-say">{said.join(' ')}</p>
      </section>
      <Viewer3D
        sessionId={session.id}
        request={{
          mode: 'replay',
          result_id: resultId,
          template_version_id: comparison?.template_version_id ?? null,
          markers_id: null,
        }}
        title={t(comparison ? 'home.pictureExample' : 'home.picture')}
        near={nearOf(session)}
        player={player}
        ghost={GHOST}
        onShown={setShown}
      />
      <Transport player={player} />
      {comparison && shown?.has_ghost && <p className="muted">{t('home.example')}</p>}
    </div>
  );
}

export function MyReplayPage() {
  const { sessionId = '' } = useParams();
  const session = useSession(sessionId);
  const { data } = session;
  if (data && (isLive(data.state) || data.state === 'closing'))
    return <Navigate to={`/my/sessions/${sessionId}/live`} replace />;
  const started = data?.started_at ?? data?.created_at;
  return (
    <Page
      narrow
      compact
      title={data?.exercise_name ?? t('home.replayTitle')}
      lead={started ? weekday(started) : undefined}
      crumbs={[{ to: '/my/results', text: t('nav.myResults') }]}
    >
      {data ? (
        <Watch key={data.id} session={data} />
      ) : session.error ? (
        <PlainProblem error={session.error} onRetry={() => void session.refetch()} />
      ) : (
        <Waiting lines={6} height={50} />
      )}
    </Page>
  );
}
