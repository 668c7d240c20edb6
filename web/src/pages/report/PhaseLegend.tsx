import { LegendRow, LegendStroke } from '../../charts/Legend';
import { t } from '../../i18n';

/** What is drawn in the curves over the phases: the template with its band, the lines of the patient, what leaves the band. */
export function PhaseLegend({ lines }: { lines: string }) {
  return (
    <ul className="paper-legend plain-list">
      <LegendRow
        sign={
          <>
            <rect className="paper-band" width="34" height="14" />
            <path className="paper-template" d="M0 7h34" />
          </>
        }
      >
        {t('phase.legendTemplate')}
      </LegendRow>
      <LegendStroke className="paper-line paper-line-strong">{lines}</LegendStroke>
      <LegendRow
        sign={
          <>
            <path className="paper-outside" d="M0 4h34" />
            <path className="paper-outside-bar" d="M1 8v6m0 -3h32m0 -3v6" />
          </>
        }
      >
        {t('report.legendOutside')}
      </LegendRow>
    </ul>
  );
}
