import { LegendRow, LegendStroke } from '../../charts/Legend';
import { t } from '../../i18n';

/** What is drawn in the curves over the phases: the template with its band, the lines of the patient, what leaves the band. */
export function PhaseLegend({ lines }: { lines: string }) {
  return (
    <ul className="paper-legend plain-list">
      <LegendRow
        sign={
          <>
            <rect className="chart-band" width="34" height="14" />
            <path className="chart-template" d="M0 7h34" />
          </>
        }
      >
        {t('phase.legendTemplate')}
      </LegendRow>
      <LegendStroke className="chart-line chart-line-strong">{lines}</LegendStroke>
      <LegendRow
        sign={
          <>
            <path className="chart-outside" d="M0 4h34" />
            <path className="chart-outside-bar" d="M1 8v6m0 -3h32m0 -3v6" />
          </>
        }
      >
        {t('report.legendOutside')}
      </LegendRow>
    </ul>
  );
}
