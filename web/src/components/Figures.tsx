// Drawn people: where sensors are worn, and which sit wrong. Seen from the front, so the patient's right is on the left.
import type { Placement, SensorFinding } from '../api/types';
import { t } from '../i18n';
import { placementList } from '../lib/channels';
import './Figures.css';

const BODY = {
  head: 'M100 12c13 0 22 10 22 24s-9 27-22 27-22-13-22-27 9-24 22-24z',
  trunk:
    'M92 64h16c2 7 10 10 22 13 10 3 14 8 14 17l-6 62c-1 12-2 20 0 34H62c2-14 1-22 0-34l-6-62c0-9 4-14 14-17 12-3 20-6 22-13z',
  legs: 'M63 190h74l-3 84-4 96h-22l-5-96-3-58-3 58-5 96H70l-4-96z',
  armRight: 'M57 90c-9 3-12 11-13 20l-6 48-5 42-3 22c-1 8 1 17 5 17s6-7 7-15l6-24 8-42 6-42z',
  armLeft: 'M143 90c9 3 12 11 13 20l6 48 5 42 3 22c1 8-1 17-5 17s-6-7-7-15l-6-24-8-42-6-42z',
} as const;

const SPOTS: Partial<Record<Placement, readonly [number, number]>> = {
  head: [100, 26],
  sternum: [100, 102],
  pelvis: [100, 178],
  upper_arm_right: [49, 124],
  forearm_right: [42, 178],
  hand_right: [35, 224],
  upper_arm_left: [151, 124],
  forearm_left: [158, 178],
  hand_left: [165, 224],
  thigh_right: [80, 232],
  shank_right: [82, 306],
  thigh_left: [120, 232],
  shank_left: [118, 306],
  foot_right: [80, 366],
  foot_left: [120, 366],
};

function Person({ children, label }: { children?: React.ReactNode; label: string }) {
  return (
    <svg className="figure-person" viewBox="0 0 200 385" role="img" aria-label={label}>
      <g fill="var(--tm-figure)" stroke="var(--tm-line-strong)" strokeWidth="1.5" strokeLinejoin="round">
        <path d={BODY.legs} />
        <path d={BODY.armRight} />
        <path d={BODY.armLeft} />
        <path d={BODY.trunk} />
        <path d={BODY.head} />
      </g>
      {children}
    </svg>
  );
}

/** Where the chosen sensors are worn. */
export function WornFigure({ worn }: { worn: readonly Placement[] }) {
  const label = worn.length ? t('figure.worn', { places: placementList(worn) }) : t('figure.nothingWorn');
  return (
    <Person label={label}>
      {(Object.entries(SPOTS) as [Placement, readonly [number, number]][]).map(([placement, [x, y]]) =>
        worn.includes(placement) ? (
          <rect
            key={placement}
            x={x - 9}
            y={y - 9}
            width="18"
            height="18"
            rx="5"
            fill="var(--tm-accent)"
            stroke="var(--tm-surface)"
            strokeWidth="2"
          />
        ) : (
          <circle
            key={placement}
            cx={x}
            cy={y}
            r="4.5"
            fill="none"
            stroke="var(--tm-line-strong)"
            strokeWidth="1.5"
            strokeDasharray="2 2.5"
          />
        ),
      )}
      <text x="14" y="376" fontSize="13" fill="var(--tm-muted)">
        {t('figure.right')}
      </text>
      <text x="186" y="376" fontSize="13" fill="var(--tm-muted)" textAnchor="end">
        {t('figure.left')}
      </text>
    </Person>
  );
}

/** Which sensors sit wrong: marked on the body, with an arrow between two that were swapped. */
export function FindingFigure({ findings }: { findings: readonly SensorFinding[] }) {
  const wrong = [...new Set(findings.flatMap((finding) => finding.placements))];
  const swaps = findings.flatMap(({ code, placements }) => {
    const [a, b] = [SPOTS[placements[0] ?? 'head'], SPOTS[placements[1] ?? 'head']];
    return code.startsWith('swapped') && placements.length > 1 && a && b ? [[a, b] as const] : [];
  });
  return (
    <Person label={t('figure.finding', { places: placementList(wrong) })}>
      {swaps.map(([[ax, ay], [bx, by]]) => (
        <path
          key={`${ax}/${ay}`}
          d={`M${ax} ${ay}Q${(ax + bx) / 2 + (ax === bx ? 40 : 0)} ${(ay + by) / 2 - 46} ${bx} ${by}`}
          fill="none"
          stroke="var(--tm-alert)"
          strokeWidth="3"
          strokeDasharray="6 5"
        />
      ))}
      {wrong.map((placement) => {
        const spot = SPOTS[placement];
        if (!spot) return null;
        const [x, y] = spot;
        return (
          <g key={placement}>
            <circle cx={x} cy={y} r="13" fill="var(--tm-alert)" stroke="var(--tm-surface)" strokeWidth="2" />
            <text x={x} y={y + 6} fontSize="18" fontWeight="700" fill="var(--tm-surface)" textAnchor="middle">
              !
            </text>
          </g>
        );
      })}
      <text x="14" y="376" fontSize="13" fill="var(--tm-muted)">
        {t('figure.right')}
      </text>
      <text x="186" y="376" fontSize="13" fill="var(--tm-muted)" textAnchor="end">
        {t('figure.left')}
      </text>
    </Person>
  );
}
