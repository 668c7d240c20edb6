// Nobody with an implant near a magnetic source: two questions, and what follows when one is not answered by no.
import { IconHeartOff } from '@tabler/icons-react';
import { RadioCards } from '../../components/forms/Choice';
import { t } from '../../i18n';
import { bodyLength, number } from '../../lib/format';
import { isForbidden, type Implants, type Word } from './magneticSetup';

interface Props {
  value: Implants;
  onChange: (value: Implants) => void;
  /** Where the field has fallen below the limit, once the source is known. */
  keepAwayM?: number | null;
  limitT?: number;
}

export function ImplantQuestions({ value, onChange, keepAwayM, limitT }: Props) {
  const options: { value: Word; title: string }[] = [
    { value: 'none', title: t('magnetic.no') },
    { value: 'some', title: t('magnetic.yes') },
  ];
  return (
    <div className="stack">
      <div className="banner banner-alert" style={{ marginBottom: 0 }}>
        <IconHeartOff size={28} style={{ flexShrink: 0 }} aria-hidden />
        <div>
          <p className="strong">{t('magnetic.warning')}</p>
          <p>{t('magnetic.which')}</p>
          {typeof keepAwayM === 'number' && limitT !== undefined && (
            <p>{t('magnetic.keepAway', { distance: bodyLength(keepAwayM), limit: number(1000 * limitT, 1) })}</p>
          )}
        </div>
      </div>
      <RadioCards<Word>
        legend={t('magnetic.patient')}
        options={options}
        value={value.patient}
        onChange={(patient) => onChange({ ...value, patient })}
        columns={2}
      />
      <RadioCards<Word>
        legend={t('magnetic.nearby')}
        options={options}
        value={value.nearby}
        onChange={(nearby) => onChange({ ...value, nearby })}
        columns={2}
      />
      {isForbidden(value) && (
        <p className="alert-text" role="alert">
          {t('magnetic.forbidden')}
        </p>
      )}
      <p className="muted small">{t('magnetic.noted')}</p>
    </div>
  );
}
