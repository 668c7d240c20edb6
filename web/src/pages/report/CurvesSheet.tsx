import type { ComparisonDetail } from '../../api/types';
import { PhaseChart } from '../../charts/PhaseChart';
import { t } from '../../i18n';
import { channelLabel } from '../../lib/channels';
import { isOfStrides, outsideOf, pickCurves, primaryChannel } from '../../lib/assessment/comparison';
import { withUnit } from '../../lib/format';
import { PhaseLegend } from './PhaseLegend';
import { Sheet, type ReportProps } from './Sheet';
import './CurvesSheet.css';

const MOST_CURVES = 6;

/** Sheet 2: the curves that matter, the main one first. */
export function CurvesSheet({
  session,
  patient,
  comparison,
  page = 2,
}: Pick<ReportProps, 'session' | 'patient'> & { comparison: ComparisonDetail; page?: number }) {
  const length = (channel: string) =>
    outsideOf(comparison, channel).reduce((sum, one) => sum + one.until - one.from, 0);
  const left = new Set(comparison.repetitions.flatMap((one, index) => (one.repetition.is_kept ? [] : [index])));
  const curves = pickCurves(comparison.curves, true, primaryChannel(comparison.summary), length).slice(0, MOST_CURVES);
  return (
    <Sheet title={t('report.curves')} number={page} session={session} patient={patient}>
      <PhaseLegend
        lines={t(isOfStrides(comparison) ? 'report.legendStrides' : 'report.legendRepetitions', {
          count: comparison.repetition_count,
        })}
      />
      <div className="paper-curves">
        {curves.map((curve) => {
          const stretches = outsideOf(comparison, curve.channel);
          const outside = new Set(stretches.map((one) => one.repetition)).size;
          const { convention } = channelLabel(curve.channel);
          return (
            <figure key={curve.channel} className="paper-figure">
              <figcaption>
                {withUnit(curve.label, curve.unit)}
                {convention && <span className="paper-convention">{convention}</span>}
              </figcaption>
              <PhaseChart isOnPaper curve={curve} left={left} outside={stretches} phases={comparison.phases} />
              <p className="paper-note">
                {outside === 0
                  ? t('compare.inside')
                  : t('report.outside', { count: outside, of: comparison.repetition_count })}
              </p>
            </figure>
          );
        })}
      </div>
      <p className="paper-note">{t('report.curvesHelp')}</p>
    </Sheet>
  );
}
