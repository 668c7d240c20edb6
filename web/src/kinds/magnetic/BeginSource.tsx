// A new session with a magnetic source: where it is worn, which source it is, and whether it may be switched on at all.
import { useState } from 'react';
import { useNewSourceSession } from '../../api/changes';
import { useMagneticSources } from '../../api/queries';
import { t } from '../../i18n';
import { BeginForm } from '../BeginForm';
import type { BeginProps } from '../kind';
import { ImplantQuestions } from './ImplantQuestions';
import { isForbidden, isSafe, sourceParameters, UNASKED, USUAL, wornFor, type Use } from './magneticSetup';
import { SourceChoice } from './SourceChoice';

export function BeginSource(props: BeginProps) {
  const side = props.patient.affected_side;
  const create = useNewSourceSession();
  const sources = useMagneticSources(true);
  const [use, setUse] = useState<Use>('back');
  const [worn, setWorn] = useState(() => wornFor('back', side));
  const [coils, setCoils] = useState(USUAL);
  const [sourceId, setSourceId] = useState<string | null>(null);
  const [implants, setImplants] = useState(UNASKED);
  // What is to be measured cannot be known already.
  const wornId = use === 'bench' ? null : sourceId;
  const declared = {
    placements: [worn.source, ...worn.sensors],
    orientation_parameters: sourceParameters(worn, wornId ? USUAL : coils, use),
    ...(wornId ? { magnetic_source_id: wornId } : {}),
    use_mounting: false,
  };
  return (
    <BeginForm
      {...props}
      create={create}
      declared={isSafe(implants) && worn.sensors.length > 0 ? declared : null}
      note={!isSafe(implants) && !isForbidden(implants) && <p className="muted">{t('magnetic.askFirst')}</p>}
    >
      <SourceChoice
        use={use}
        worn={worn}
        coils={coils}
        side={side}
        sources={use === 'bench' ? [] : (sources.data ?? [])}
        sourceId={wornId}
        onSource={setSourceId}
        onUse={(nextUse, nextWorn) => {
          setUse(nextUse);
          setWorn(nextWorn);
        }}
        onCoils={setCoils}
      />
      <section className="stack" aria-labelledby="implants">
        <h2 id="implants" className="protocol-title">
          {t('magnetic.safety')}
        </h2>
        <ImplantQuestions value={implants} onChange={setImplants} />
      </section>
    </BeginForm>
  );
}
