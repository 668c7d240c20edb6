// What the feet of a stored walk did over time, with the band of the template in every stride that was compared.
import { useMemo, useState } from 'react';
import { useFootCurves } from '../../../api/queries';
import type { FootCurves as Curves } from '../../../api/types';
import { PhaseLegend } from '../../../charts/PhaseChart';
import { Traces } from '../../../charts/Traces';
import { QueryBoundary } from '../../../components/Feedback';
import { ChannelPicker } from '../../../components/forms/ChannelPicker';
import { t } from '../../../i18n';
import { withColumns } from '../../../player/beside';
import { sigmaOf } from '../../magnetic/magnetic';
import type { CurvesProps } from '../../kind';

const SHOWN_FIRST = 3;

function columnsOf(curves: Curves): [Float64Array, Map<string, Float32Array>] {
  const plain = (values: readonly (number | null)[]) => Float32Array.from(values, (value) => value ?? NaN);
  return [
    Float64Array.from(curves.time_s),
    new Map(
      curves.curves.flatMap((one) => [
        [one.channel, plain(one.value)] as const,
        [sigmaOf(one.channel), plain(one.sigma)] as const,
      ]),
    ),
  ];
}

function Shown({ curves, player, onSeek, templateAt, compared }: CurvesProps & { curves: Curves }) {
  const [chosen, setChosen] = useState<string[] | null>(null);
  const names = useMemo(() => curves.curves.map((one) => one.channel), [curves]);
  const channels = useMemo(
    () => chosen ?? (compared.length > 0 ? [...compared] : names.slice(0, SHOWN_FIRST)),
    [chosen, compared, names],
  );
  const whole = useMemo(() => withColumns(player, ...columnsOf(curves)), [player, curves]);
  return (
    <>
      <div className="card-head">
        <p className="muted small">{t(compared.length > 0 ? 'walk.curvesWithTemplate' : 'walk.curvesHelp')}</p>
        <span className="end">
          <ChannelPicker available={names} value={channels} onChange={setChosen} title={t('walk.chooseCurves')} />
        </span>
      </div>
      {compared.length > 0 && <PhaseLegend withOutside={false} patient />}
      <Traces player={whole} channels={channels} windowS={6} templateAt={templateAt} onSeek={onSeek} />
    </>
  );
}

export function FootCurves(props: CurvesProps) {
  const curves = useFootCurves(props.session.id, props.resultId);
  return (
    <QueryBoundary of={curves} lines={6} height={60}>
      {(found) => <Shown {...props} curves={found} />}
    </QueryBoundary>
  );
}
