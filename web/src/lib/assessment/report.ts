import type { ComparisonDetail, MeasureValue, ProgressMeasure } from '../../api/types';
import { t } from '../../i18n';

export interface ReportRow {
  value: MeasureValue;
  progress: ProgressMeasure | null;
}

/** In the order in which they are shown. */
export const MEASURE_GROUPS = [
  'range',
  'timing',
  'shape',
  'smoothness',
  'coordination',
  'path',
  'compensation',
] as const;
const MOST_ROWS = 10;

/** The measures for one page: of each group the first ones in turn, in the order of the groups; `main` leads its own. */
export function reportRows(
  summary: readonly MeasureValue[],
  progress: readonly ProgressMeasure[],
  most = MOST_ROWS,
  main = '',
): ReportRow[] {
  const known = summary
    .filter((one) => typeof one.value === 'number' && !one.measure.startsWith('range_ratio:'))
    .sort((a, b) => Number(b.measure === main) - Number(a.measure === main));
  const groups = MEASURE_GROUPS.map((group) => known.filter((one) => one.group === group));
  const chosen = new Set<MeasureValue>();
  for (let round = 0; chosen.size < most && groups.some((group) => group.length > round); round += 1) {
    for (const group of groups) {
      const next = group[round];
      if (next && chosen.size < most) chosen.add(next);
    }
  }
  return groups
    .flat()
    .filter((one) => chosen.has(one))
    .map((value) => ({ value, progress: progress.find((one) => one.measure === value.measure) ?? null }));
}

/** How the repetitions were counted while they were made, as the patient saw it; empty where nothing was counted. */
export function countedText(repetitions: ComparisonDetail['repetitions']): string {
  const all = repetitions.map((one) => one.repetition).filter((one) => one.counted);
  const numbers = (kind: string) =>
    all
      .filter((one) => one.counted === kind)
      .map((one) => one.number)
      .join(', ');
  if (all.length === 0) return '';
  const valid = all.filter((one) => one.counted === 'valid').length;
  return [
    t('report.counted', { valid, count: all.length }),
    numbers('partial') && t('report.countedPartial', { numbers: numbers('partial') }),
    numbers('wrong') && t('report.countedWrong', { numbers: numbers('wrong') }),
  ]
    .filter(Boolean)
    .join('; ');
}

/** The repetitions of a session: as they were counted, and how many were evaluated where that says more. */
export function repetitionsText({
  repetitions,
  repetition_count: evaluated,
}: Pick<ComparisonDetail, 'repetitions' | 'repetition_count'>): string {
  const counted = countedText(repetitions);
  const isAll = counted && repetitions.every((one) => one.repetition.counted) && evaluated === repetitions.length;
  return [counted, !isAll && t('report.repetitions', { count: evaluated })].filter(Boolean).join(' · ');
}
