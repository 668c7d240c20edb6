// Where nothing can be drawn in 3D: the same positions as lines, from two sides, and a sentence that says why.
import { useEffect, useMemo, useState } from 'react';
import { t } from '../../i18n';
import { placementLabel } from '../../lib/channels';
import { useSnapshot } from '../../player/hooks';
import type { Player } from '../../player/types';
import { middleOf, sceneOf, seen, type FlatScene, type FlatView, type Place } from './scene';
import './FlatFigure.css';

/** A position that is older than this is not of now. */
const OF_NOW_S = 1;
const EVERY_MS = 66;
/** For those who asked for less motion. */
const CALM_MS = 250;
const HEAD_M = 0.1;
const NONE: ReadonlyMap<string, Place> = new Map();

/** The newest known positions at the player's clock; without those of a limb whose sensor gives nothing. */
function placesAt(player: Player, points: readonly string[]): ReadonlyMap<string, Place> {
  const { timeS } = player.clock();
  const names = points.flatMap((point) => [`${point}.x`, `${point}.y`, `${point}.z`]);
  const read = player.read(timeS - OF_NOW_S, timeS + 1e-3, names);
  const last = read.timeS.length - 1;
  if (last < 0) return NONE;
  const value = (column: number) => read.values[column]?.[last] ?? NaN;
  return new Map(
    points
      .map((point, at) => [point, [value(3 * at), value(3 * at + 1), value(3 * at + 2)] as const] as const)
      .filter(([, place]) => place.every(Number.isFinite)),
  );
}

function usePlaces(player: Player, points: readonly string[] | undefined): ReadonlyMap<string, Place> {
  const [places, setPlaces] = useState(NONE);
  useEffect(() => {
    if (!points) return;
    const calm = window.matchMedia('(prefers-reduced-motion: reduce)').matches;
    let [frame, lastMs, drawn] = [0, -Infinity, ''];
    const step = (ms: number) => {
      frame = requestAnimationFrame(step);
      if (ms - lastMs < (calm ? CALM_MS : EVERY_MS)) return;
      const sign = `${player.clock().timeS}/${player.getSnapshot().epoch}`;
      if (sign === drawn) return;
      [lastMs, drawn] = [ms, sign];
      setPlaces(placesAt(player, points));
    };
    frame = requestAnimationFrame(step);
    return () => cancelAnimationFrame(frame);
  }, [player, points]);
  return places;
}

function Picture({ scene, view, at }: { scene: FlatScene; view: FlatView; at: ReadonlyMap<string, Place> }) {
  const middle = middleOf(scene, at);
  const spot = (name: string) => {
    const place = at.get(name);
    return place && seen([place[0] - middle[0], place[1] - middle[1], place[2] - middle[2]], view);
  };
  const head = spot('head');
  const { half } = scene;
  return (
    <figure>
      <svg viewBox={`${-half} ${-half} ${2 * half} ${2 * half}`} aria-hidden data-view={view}>
        {scene.bones.map(({ from, to, isMeasured }) => {
          const [start, end] = [spot(from), spot(to)];
          if (!start || !end) return null;
          return (
            <line
              key={to + from}
              className={isMeasured ? 'flat-measured' : undefined}
              data-bone={to}
              x1={start[0]}
              y1={start[1]}
              x2={end[0]}
              y2={end[1]}
            />
          );
        })}
        {scene.bones.length > 0 && head && <circle cx={head[0]} cy={head[1]} r={HEAD_M} />}
        {view === 'front' &&
          (['left', 'right'] as const).map((side) => {
            const shoulder = spot(`shoulder_${side}`);
            return (
              shoulder && (
                <text key={side} x={shoulder[0]} y={shoulder[1] - 0.06} fontSize={0.11}>
                  {t(`flat.${side}`)}
                </text>
              )
            );
          })}
        {scene.bones.length === 0 &&
          [...at.keys()].map((name) => {
            const here = spot(name);
            return (
              here && (
                <g key={name}>
                  <circle className="flat-measured" cx={here[0]} cy={here[1]} r={half / 16} />
                  <text x={here[0]} y={here[1] - half / 8} fontSize={half / 10}>
                    {placementLabel(name)}
                  </text>
                </g>
              )
            );
          })}
      </svg>
      <figcaption>{t(`flat.view.${view}`)}</figcaption>
    </figure>
  );
}

/** A stick figure from the front and from the side. */
export default function FlatFigure({ player, title, isPlain }: { player: Player; title: string; isPlain?: boolean }) {
  const { columns } = useSnapshot(player);
  const scene = useMemo(() => (columns ? sceneOf(columns.layout) : undefined), [columns]);
  const places = usePlaces(player, scene?.points);
  const isThere = Boolean(scene) && places.size > 1;
  return (
    <div className="viewer-box flat" data-testid="flat">
      <p role="note">
        {t(scene === null ? 'flat.none' : 'flat.why')}
        {!isPlain && <span className="muted"> {t('flat.help')}</span>}
      </p>
      {scene && (
        <div className="flat-views" role="img" aria-label={title}>
          {scene.views.map((view) => (
            <Picture key={view} scene={scene} view={view} at={places} />
          ))}
          {!isThere && <p className="flat-waiting muted">{t('flat.waiting')}</p>}
        </div>
      )}
    </div>
  );
}
