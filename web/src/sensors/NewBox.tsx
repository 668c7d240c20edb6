// A box that this patient has not used before: it joins by a code or its picture, and then every exercise by itself.
import { Button } from '@mantine/core';
import { usePairingCode } from '../api/changes';
import { Pairing } from '../components/account/Pairing';
import { t } from '../i18n';
import { PlainProblem } from '../pages/mine/PlainProblem';

/** How long a box that was joined at home may send. */
const DAYS = 90;

export default function NewBox({ patientId, onDone }: { patientId: string; onDone: () => void }) {
  const pairing = usePairingCode(patientId);
  if (pairing.data)
    return <Pairing made={pairing.data} help={(time) => t('sensors.boxHelp', { time })} onDone={onDone} />;
  return (
    <>
      <p>{t('sensors.boxSteps')}</p>
      <Button
        size="xl"
        fullWidth
        loading={pairing.isPending}
        onClick={() => pairing.mutate({ label: t('sensors.boxLabel'), days: DAYS })}
      >
        {t('sensors.boxGo')}
      </Button>
      {pairing.error && <PlainProblem error={pairing.error} />}
    </>
  );
}
