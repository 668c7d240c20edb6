// Words of the pages for researchers and integrators: accuracy, estimators side by side.
import type { Translated } from '../..';
import type { research as english } from '../../en/staff/research';

export const research: Translated<typeof english> = {
  'accuracy.title': 'Genauigkeit',
  'accuracy.lead':
    'Veröffentlichte Experimente, mit dieser Version wiederholt: die veröffentlichte Zahl, die Anforderung und unser Ergebnis.',
  'accuracy.overview': '{met} von {all} Experimenten erfüllen die Anforderung',
  'accuracy.notMet': 'Offen sind {open}: Die Grenze liegt im Konfidenzintervall. Nicht erreicht wird sie von {short}.',
  'accuracy.how':
    'Jedes Experiment läuft mit zufälligen Startwerten, {seeds}, wenn nichts anderes dabeisteht, oder mit den genannten Aufzeichnungen. Beurteilt wird, was neun von zehn Startwerten erreichen, der Median oder das Mittel, mit dem 95-%-Konfidenzintervall: Ein Experiment besteht nur, wenn das ganze Intervall die Grenze einhält. Zahlen mit „nur gezeigt“ haben keine Grenze.',
  'accuracy.made': 'Version {version}, gemessen am {date} in {seconds} s. {machine}.',
  'accuracy.command': 'Befehl, der alles noch einmal misst',
  'accuracy.commandOf': 'Befehl, der „{title}“ wiederholt',
  'accuracy.again': 'Gemessen mit {seeds} Startwerten in {seconds} s. Zum Wiederholen:',
  'accuracy.figure': 'Zahl',
  'accuracy.published': 'Veröffentlicht',
  'accuracy.required': 'Gefordert',
  'accuracy.judged': 'Unsere, beurteilt',
  'accuracy.interval': '95-%-Intervall',
  'accuracy.from': '{low} bis {high}',
  'accuracy.median': 'Unsere, Median',
  'accuracy.worst': 'Unsere, schlechteste',
  'accuracy.count': 'Anzahl',
  'accuracy.mark': 'Urteil',
  'accuracy.met': 'Erfüllt',
  'accuracy.open': 'Offen',
  'accuracy.missed': 'Verfehlt',
  'accuracy.shownOnly': 'nur gezeigt',
  'accuracy.more': { one: '{count} weitere Zahl anzeigen', other: '{count} weitere Zahlen anzeigen' },
  'accuracy.moreOf': '{title}, weitere Zahlen',
  'accuracy.plotLabel': '{title}: {y} über {x}, mit den Linien {lines}',

  'differences.open': 'Ergebnisse vergleichen',
  'differences.title': 'Schätzverfahren im Vergleich',
  'differences.table': 'Wie weit auseinander (RMS)',
  'differences.reference': 'Verglichen mit',
  'differences.help':
    'Quadratisches Mittel der Differenz in jedem Gelenkwinkel, wo beide Ergebnisse gelten: nicht in Lücken, beim Anlaufen oder nahe einer singulären Stellung. Der Winkel mit der größten Abweichung steht zuerst.',
  'differences.overall': 'Alle Winkel',
  'differences.angle': 'Gezeigter Winkel',
  'differences.time': 'Zeit (s)',
  'differences.degrees': 'Winkel (°)',
  'differences.curves': '{angle} über die Zeit, geschätzt von {lines}',
  'differences.largest': 'Größte Differenz: {degrees} bei {at}.',
  'differences.live': '{title}, live',
  'differences.changed': { one: '{name}, {count} Parameter geändert', other: '{name}, {count} Parameter geändert' },
  'differences.emptyTitle': 'Bisher nur ein Ergebnis',
  'differences.emptyText':
    'Öffnen Sie die Einzelheiten der Sitzung und lassen Sie alle Schätzverfahren laufen; die Ergebnisse stehen dann hier nebeneinander.',
};
