// What differs from the template: plain findings first, then the measures, then the curves with what leaves the band.
import { Button, Select } from '@mantine/core';
import { IconRouteOff } from '@tabler/icons-react';
import { useState } from 'react';
import { Link } from 'react-router';
import { useCompare } from '../../../api/changes';
import { useTemplates } from '../../../api/queries';
import type { ComparisonDetail, MeasureValue, PhaseCurve, SessionDetail } from '../../../api/types';
import { PhaseChart, PhaseLegend } from '../../../charts/PhaseChart';
import { symmetryText } from '../../../charts/ProgressChart';
import { WeightedSum } from '../../../components/WeightedSum';
import { Empty, Problem } from '../../../components/Feedback';
import { t, tOr } from '../../../i18n';
import { zeroOf } from '../../../lib/channels';
import { quantity, uncertain } from '../../../lib/format';
import { isOfStrides, outsideOf, pickCurves, primaryChannel } from '../../../lib/assessment/comparison';
import { MEASURE_GROUPS } from '../../../lib/assessment/report';
import './ComparisonPanel.css';

export interface ComparisonPanelProps {
  session: SessionDetail;
  resultId: string;
  comparison: ComparisonDetail | null;
  hasComparison: boolean;
  selected: number | null;
  onSelect: (repetition: number | null) => void;
  onPhase: (repetition: number, templatePhase: number) => void;
  /** Where the moment that is played stands in the curves. */
  phaseNow?: () => number | null;
}

const SHOWN_FIRST = 3;

function Start({ session, resultId }: { session: SessionDetail; resultId: string }) {
  const templates = useTemplates(session.exercise_id ?? null, session.patient_id, session.exercise_id !== null);
  const compare = useCompare(session.id);
  const [picked, setPicked] = useState<string | null>(null);
  const versions = (templates.data ?? []).flatMap((template) => {
    const newest = template.versions[0];
    return newest
      ? [{ value: newest.id, label: t('template.version', { name: template.name, number: newest.number }) }]
      : [];
  });
  if (versions.length === 0) {
    return (
      <Empty
        level={3}
        icon={<IconRouteOff size={44} aria-hidden />}
        title={t('compare.noTemplate')}
        action={
          session.may_treat && (
            <Button
              component={Link}
              to={`/templates/record?patient=${session.patient_id}${session.exercise_id ? `&exercise=${session.exercise_id}` : ''}`}
            >
              {t('template.record')}
            </Button>
          )
        }
      >
        {t('compare.noTemplateText')}
      </Empty>
    );
  }
  const versionId = picked ?? versions[0]?.value ?? null;
  return (
    <div className="stack">
      <p>{t('compare.notYet')}</p>
      <Select label={t('replay.template')} data={versions} value={versionId} onChange={setPicked} />
      {compare.error && <Problem error={compare.error} />}
      <div>
        <Button
          loading={compare.isPending}
          onClick={() => versionId && compare.mutate({ template_version_id: versionId, result_id: resultId })}
        >
          {t('compare.now')}
        </Button>
      </div>
    </div>
  );
}

/** One measure of the session beside the template's. */
function Measures({ measures }: { measures: readonly MeasureValue[] }) {
  return (
    <table className="plain-table measures stacked-table">
      <caption className="visually-hidden">{t('compare.summary')}</caption>
      <thead>
        <tr>
          <th scope="col">{t('compare.measure')}</th>
          <th scope="col">{t('compare.patient')}</th>
          <th scope="col">{t('compare.template')}</th>
        </tr>
      </thead>
      {MEASURE_GROUPS.map((group) => {
        const rows = measures.filter((one) => one.group === group);
        if (rows.length === 0) return null;
        return (
          <tbody key={group}>
            <tr className="group-row">
              <th scope="rowgroup" colSpan={3}>
                {tOr(`group.${group}`, group)}
              </th>
            </tr>
            {rows.map((one) => (
              <tr key={one.measure}>
                <th scope="row">{one.label}</th>
                <td className="number" data-label={t('compare.patient')}>
                  {one.count > 0 && typeof one.value === 'number' && (
                    <>
                      {uncertain(one.value, one.uncertainty ?? null, one.unit)}{' '}
                      <span className="muted small">{t('compare.count', { count: one.count })}</span>
                    </>
                  )}
                  {one.note ? <span className="measure-note muted small">{one.note}</span> : one.value === null && '–'}
                </td>
                <td className="number muted" data-label={t('compare.template')}>
                  {quantity(one.template_value, one.unit)}
                </td>
              </tr>
            ))}
          </tbody>
        );
      })}
    </table>
  );
}

/** Each measure beside that of the other side's newest session, and how alike both are. */
function BothSides({ measures }: { measures: NonNullable<ComparisonDetail['other_side']> }) {
  return (
    <table className="plain-table measures stacked-table">
      <caption className="visually-hidden">{t('compare.bothSides')}</caption>
      <thead>
        <tr>
          <th scope="col">{t('compare.measure')}</th>
          <th scope="col">{t('compare.thisSession')}</th>
          <th scope="col">{t('compare.otherSide')}</th>
        </tr>
      </thead>
      <tbody>
        {measures.map((one) => (
          <tr key={one.measure}>
            <th scope="row">
              {one.label}
              <span className="measure-note muted small">
                {symmetryText(one.symmetry_ratio, one.symmetry_ratio_sigma, one.symmetry_angle_percent)}
              </span>
            </th>
            <td className="number" data-label={t('compare.thisSession')}>
              {quantity(one.value, one.unit)}
            </td>
            <td className="number" data-label={t('compare.otherSide')}>
              {quantity(one.other_value, one.unit)}{' '}
              <span className="muted small">{t('compare.count', { count: one.other_count })}</span>
            </td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

/** A curve with, beneath it, a button for every stretch that leaves the band: what the pointer does, the keyboard can. */
function Curve({
  curve,
  comparison,
  selected,
  onPhase,
  phaseNow,
}: { curve: PhaseCurve; comparison: ComparisonDetail } & Pick<
  ComparisonPanelProps,
  'selected' | 'onPhase' | 'phaseNow'
>) {
  const left = new Set(comparison.repetitions.flatMap((one, index) => (one.repetition.is_kept ? [] : [index])));
  const outside = outsideOf(comparison, curve.channel);
  const stretches = outside.filter((one) => selected === null || one.repetition === selected);
  return (
    <section className="curve">
      <h3>{curve.label}</h3>
      {zeroOf(curve.channel) !== 0 && <p className="muted small">{t('traces.neutralZero')}</p>}
      <PhaseChart
        curve={curve}
        phases={comparison.phases}
        outside={outside}
        left={left}
        selected={selected}
        height={220}
        phaseNow={phaseNow}
        onPhase={(phase, repetition) => {
          const target = selected ?? repetition;
          if (target !== null) onPhase(target, phase);
        }}
      />
      {stretches.length === 0 ? (
        <p className="muted small">{t(curve.is_judged === false ? 'design.isWatched' : 'compare.inside')}</p>
      ) : (
        <details className="as-table">
          <summary>{t('compare.outsideCount', { count: stretches.length })}</summary>
          <ul className="plain-list stretches">
            {stretches.map((one) => (
              <li key={`${one.repetition}/${one.from}`}>
                <Button
                  size="compact-md"
                  variant="default"
                  onClick={() => onPhase(one.repetition, (one.from + one.until - 1) / 2)}
                >
                  {t(isOfStrides(comparison) ? 'compare.stretchStride' : 'compare.stretch', {
                    number: one.number,
                    from: one.from,
                    until: one.until - 1,
                  })}
                </Button>
              </li>
            ))}
          </ul>
        </details>
      )}
    </section>
  );
}

export function ComparisonPanel({
  session,
  resultId,
  comparison,
  hasComparison,
  selected,
  onSelect,
  onPhase,
  phaseNow,
}: ComparisonPanelProps) {
  const [showsAll, setShowsAll] = useState(false);
  if (!hasComparison) return <Start session={session} resultId={resultId} />;
  if (!comparison) return null;
  const areStrides = isOfStrides(comparison);
  if (comparison.repetitions.length === 0) {
    return (
      <Empty level={3} title={t(areStrides ? 'compare.noStrides' : 'compare.noRepetitions')}>
        {comparison.findings[0] ?? t('compare.noRepetitionsText')}
      </Empty>
    );
  }
  const length = (channel: string) =>
    outsideOf(comparison, channel).reduce((sum, one) => sum + one.until - one.from, 0);
  const ordered = pickCurves(comparison.curves, true, primaryChannel(comparison.summary), length);
  const curves = showsAll ? ordered : ordered.slice(0, SHOWN_FIRST);
  return (
    <div className="stack">
      <div>
        <p className="muted small">
          {t(areStrides ? 'compare.withStrides' : 'compare.with', {
            name: comparison.template_name,
            count: comparison.repetition_count,
          })}
        </p>
        <ul className="findings">
          {comparison.findings.map((finding) => (
            <li key={finding}>{finding}</li>
          ))}
        </ul>
      </div>
      <div className="curves-head">
        <Select
          size="sm"
          w={240}
          label={t('compare.show')}
          value={selected === null ? 'all' : String(selected)}
          onChange={(value) => onSelect(value === 'all' || value === null ? null : Number(value))}
          data={[
            { value: 'all', label: t(areStrides ? 'compare.allStrides' : 'compare.allRepetitions') },
            ...comparison.repetitions.map((one, index) => ({
              value: String(index),
              label: t(areStrides ? 'repetition.stride' : 'repetition.numbered', { number: one.repetition.number }),
            })),
          ]}
        />
        <p className="muted small">{t('compare.clickHelp')}</p>
      </div>
      <PhaseLegend withOutside patient />
      {curves.map((curve) => (
        <Curve
          key={curve.channel}
          curve={curve}
          comparison={comparison}
          selected={selected}
          onPhase={onPhase}
          phaseNow={phaseNow}
        />
      ))}
      {ordered.length > SHOWN_FIRST && (
        <div>
          <Button variant="default" aria-expanded={showsAll} onClick={() => setShowsAll(!showsAll)}>
            {showsAll ? t('compare.fewerCurves') : t('compare.moreCurves')}
          </Button>
        </div>
      )}
      {comparison.weighted_sum && <WeightedSum sum={comparison.weighted_sum} />}
      <details className="as-table">
        <summary>{t('compare.summary')}</summary>
        <Measures measures={comparison.summary} />
      </details>
      {comparison.other_side && comparison.other_side.length > 0 && (
        <details className="as-table">
          <summary>{t('compare.bothSides')}</summary>
          <BothSides measures={comparison.other_side} />
        </details>
      )}
    </div>
  );
}
