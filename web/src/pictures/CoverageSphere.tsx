// Where the magnetic field was seen: the ball of all directions as two discs, its upper and its lower half.
import { t } from '../i18n';
import { number } from '../lib/format';
import './pictures.css';
import './CoverageSphere.css';

const RADIUS = 92;

/** Equal area from the pole: a field near the rim is as large as one in the middle. */
export function onDisc([x, y, z]: readonly [number, number, number]): readonly [number, number] {
  const outward = Math.sqrt(Math.max(0, 1 - Math.abs(z)));
  const flat = Math.hypot(x, y) || 1;
  return [(outward * x) / flat, (outward * -y) / flat];
}

export function CoverageSphere({
  directions,
  visited,
  coverage,
}: {
  directions: readonly (readonly [number, number, number])[];
  visited: readonly boolean[];
  coverage: number | null;
}) {
  // Half the distance between neighbours, when the directions lie evenly.
  const size = Math.max(3.5, (RADIUS * 0.86) / Math.sqrt(Math.max(1, directions.length / 2)));
  const seen = visited.filter(Boolean).length;
  return (
    <svg
      className="coverage"
      viewBox="0 0 410 226"
      role="img"
      aria-label={t('compass.sphere', { seen, all: directions.length, percent: number(100 * (coverage ?? 0)) })}
    >
      {([0, 1] as const).map((half) => (
        <g key={half} transform={`translate(${102 + half * 206} 102)`}>
          <circle className="figure-ball" r={RADIUS + 4} />
          {directions.map((direction, index) => {
            if (direction[2] < 0 !== (half === 1)) return null;
            const [x, y] = onDisc(direction);
            return (
              <circle
                key={index}
                className={visited[index] ? 'coverage-seen' : 'coverage-open'}
                cx={x * RADIUS}
                cy={y * RADIUS}
                r={visited[index] ? size : size * 0.7}
              />
            );
          })}
          <text className="coverage-label" y="118" textAnchor="middle">
            {half === 0 ? t('compass.upper') : t('compass.lower')}
          </text>
        </g>
      ))}
    </svg>
  );
}
