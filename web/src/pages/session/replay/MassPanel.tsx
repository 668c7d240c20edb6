// The centre of mass of a whole body over the feet: its curves, and in words what they are worth.
import { Traces } from '../../../charts/Traces';
import { t } from '../../../i18n';
import type { ReplayPlayer } from '../../../player/replay';
import { MassFacts } from './MassFacts';

interface Props {
  sessionId: string;
  resultId: string;
  player: ReplayPlayer;
  channels: readonly string[];
  onSeek: (timeS: number) => void;
}

export function MassPanel({ sessionId, resultId, player, channels, onSeek }: Props) {
  return (
    <>
      <h2 className="visually-hidden">{t('mass.title')}</h2>
      <Traces player={player} channels={channels} onSeek={onSeek} />
      <MassFacts sessionId={sessionId} resultId={resultId} />
    </>
  );
}
