// What is drawn in the 3D view of a session with a source.
import { t } from '../../i18n';
import { COIL_COLOURS } from './coils';

export function SourceLegend() {
  return (
    <ul className="legend plain-list" aria-label={t('magnetic.legend')}>
      <li>
        <svg width="34" height="16" aria-hidden>
          {COIL_COLOURS.map((colour, index) => (
            <circle
              key={colour}
              cx={7 + 10 * index}
              cy="8"
              r="5.5"
              fill="none"
              strokeWidth="2.5"
              stroke={`var(${colour})`}
            />
          ))}
        </svg>
        {t('magnetic.legend.source')}
      </li>
      <li>
        <svg width="34" height="16" aria-hidden>
          <rect
            x="7"
            y="3"
            width="20"
            height="10"
            rx="2"
            fill="var(--tm-surface)"
            stroke="var(--tm-muted)"
            strokeWidth="1.5"
          />
        </svg>
        {t('magnetic.legend.sensor')}
      </li>
      <li>
        <svg width="34" height="16" aria-hidden>
          <ellipse cx="17" cy="8" rx="14" ry="6.5" fill="#eeb26e" opacity="0.6" />
        </svg>
        {t('magnetic.legend.doubt')}
      </li>
    </ul>
  );
}
