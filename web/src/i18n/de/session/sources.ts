// Words of magnetic sources whose coils were measured, and of the word on implants while it holds.
import type { Translated } from '../..';
import type { sources as english } from '../../en/session/sources';

export const sources: Translated<typeof english> = {
  'sources.title': 'Magnetquellen',
  'sources.lead': 'Eine Quelle mit vermessenen Spulen liefert genauere Abstände als eine nur beschriebene.',
  'sources.none':
    'Noch wurde keine Quelle vermessen. Zeichnen Sie eine Werkbank-Sitzung auf (Neue Sitzung, Abstand mit Magnetquelle) und öffnen Sie sie dann.',
  'sources.line': 'Seriennummer {serial}. Feldunsicherheit {gain} %, {method} {day}.',
  'sources.method.session': 'auf der Werkbank vermessen',
  'sources.method.file': 'aus einer Datei',
  'sources.method.typed': 'von Hand eingegeben',
  'sources.import': 'Aus einer Datei übernehmen',
  'sources.importHelp': 'Wählen Sie zum Übernehmen die JSON-Datei, die „telemotion calibrate-source“ schreibt.',
  'sources.notJson':
    'Diese Datei ist keine Quelle: Es muss die JSON-Datei sein, die „telemotion calibrate-source“ schreibt.',
  'sources.retire': 'Nicht mehr anbieten',
  'sources.retireTitle': 'Diese Quelle nicht mehr anbieten?',
  'sources.retireText':
    '{name} wird für neue Sitzungen nicht mehr angeboten. Aufgezeichnete Sitzungen ändern sich nicht.',

  'sources.which': 'Welche Quelle getragen wird',
  'sources.described': 'Eine Quelle ohne vermessene Spulen',
  'sources.describedHelp':
    'Angenommene Genauigkeit der Feldstärke: ±4 %. Eine vermessene Quelle ist genauer und braucht weniger Pulse.',
  'sources.useBench': 'Werkbank: eine Quelle vermessen',
  'sources.useBenchText':
    'Niemand trägt die Quelle. Sie liegt still, und der Sensor wird an ausgemessene Stellen um sie herum gelegt.',
  'sources.length': 'Länge der Wicklung (cm)',
  'sources.depth': 'Tiefe der Wicklung (cm)',

  'sources.calibrate': 'Diese Quelle vermessen',
  'sources.calibrateHelp':
    'Für eine Werkbank-Sitzung: Die Quelle lag still, und der Sensor wurde an ausgemessene Stellen gelegt. Geben Sie für jeden Halt die Sensorposition ein, in Zentimetern von der Mitte der Quelle: x nach vorn, y nach links, z nach oben. Lassen Sie einen Halt leer, wenn er keine ausgemessene Stelle war. Sechs Stellen oder mehr, ringsum.',
  'sources.find': 'Suchen, wo der Sensor still lag',
  'sources.noStops': 'Der Sensor lag nie still, während alle Spulen aktiv waren.',
  'sources.stop': 'Halt {number}, {from} bis {to} s',
  'sources.about': 'etwa {place} cm',
  'sources.axis': '{axis}, Halt {number} (cm)',
  'sources.name': 'Name der Quelle',
  'sources.serial': 'Seriennummer',
  'sources.ruler': 'Genauigkeit der Stellen (mm)',
  'sources.keep': 'Spulen bestimmen und Quelle speichern',
  'sources.saved': '{name} ist gespeichert: Feldunsicherheit {gain} %, Positionsfehler {off} mm.',

  'safety.until': 'Die Frage wird ab {at} erneut gestellt.',
  'safety.source': 'Quelle {name}, Seriennummer {serial}: Feldunsicherheit {gain} %.',
  'safety.sourceDescribed':
    'Die Spulen dieser Quelle wurden nicht vermessen: angenommene Genauigkeit der Feldstärke ±{gain} %.',
  'safety.withdraw': 'Bestätigung zurücknehmen',
  'safety.withdrawTitle': 'Quelle anhalten?',
  'safety.withdrawText':
    'Die Quelle hält sofort an und bleibt aus, bis Sie erneut bestätigen. Die Sensoren laufen weiter, mit wachsender Unsicherheit der Abstände.',
  'safety.withdrawDo': 'Quelle anhalten',
  'safety.withdrawn': 'Sicherheitsbestätigung zurückgenommen von {name}, {at}: Die Quelle ist aus.',
  'safety.withdrawnNoName': 'Sicherheitsbestätigung zurückgenommen {at}: Die Quelle ist aus.',
  'safety.expired':
    'Die Sicherheitsbestätigung von {at} ist abgelaufen. Fragen Sie noch einmal: Es können andere Menschen im Raum sein.',
};
