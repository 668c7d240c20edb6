"""German sentences of files, findings of a comparison, grants and guesses about tables."""

from typing import Final

GERMAN: Final[dict[str, str | dict[str, str]]] = {
    "file.array_lengths": "Die Felder der Datei sind verschieden lang; die Datei ist beschädigt.",
    "file.array_shape": "Ein Feld der Datei hat die Form {shape}; erwartet wurde {expected}.",
    "file.arrays_not_numbers": "Die Felder der Datei enthalten keine Zahlen.",
    "file.arrays_not_this_kind": "Die Felder der Datei passen nicht zu dieser Art: {kind:file_kind}.",
    "file.check_time_unit": "Prüfen Sie die Spalte und ihre Einheit.",
    "file.csv_needs_mapping": "Eine CSV-Datei braucht eine Zuordnung: welche Spalte was enthält, in welcher"
    " Einheit.",
    "file.format_not_recognised": "Das Format dieser Datei wird nicht erkannt; wählen Sie es: {formats:or}.",
    "file.format_unknown": "Ein Format {format} gibt es nicht; wählen Sie {formats:or}.",
    "file.hdf5_unreadable": "Die Datei ist nicht als HDF5 lesbar; exportieren Sie sie noch einmal.",
    "file.header_then_numbers": "Die Datei ist nicht als CSV mit Zahlen unter einer Kopfzeile lesbar.",
    "file.left_out": "Nicht verwendet, Stelle nicht unterstützt: {names:and}.",
    "file.linked_data": "Der Datensatz {name} muss in der Datei selbst stehen; Verweise und andere Arten von"
    " Daten werden nicht gelesen.",
    "file.looks_like_unit": "Die Werte sehen nach {unit} aus: Geben Sie diese Einheit an.",
    "file.no_column": "Die Datei hat keine Spalte {column}; fügen Sie sie hinzu, oder wählen Sie ein anderes"
    " Format.",
    "file.no_placement": "Kein Sensor der Datei sitzt an einer unterstützten Stelle; verwenden Sie"
    " {placements:or}.",
    "file.no_time_in_row": "Zeile {row} hat keine Zeit; tragen Sie sie ein, oder entfernen Sie die Zeile.",
    "file.none_of_sensors": "Die Datei hat keinen der Sensoren {names:or}; sie passt nicht zu dieser Art:"
    " {kind:file_kind}.",
    "file.not_finite": "Die Datei enthält Werte, die nicht endlich sind; füllen oder schneiden Sie diese Lücken"
    " zuerst.",
    "file.hdf5_of_sensors": "Das ist ein HDF5 mehrerer Sensoren, wie die Software von APDM es aufzeichnet. Exportieren"
    " Sie die Aufzeichnung dort als CSV, und wählen Sie diese Datei.",
    "file.not_this_kind": "In der Datei fehlt: {missing:and}; sie passt nicht zu dieser Art: {kind:file_kind}.",
    "file.rate_impossible": "Eine Abtastrate von {rate_hz:hz~3} ist nicht möglich; die Datei ist beschädigt.",
    "file.row_incomplete": "Zeile {row} ist nicht vollständig; ergänzen oder entfernen Sie sie.",
    "file.row_not_numbers": "Eine Zeile ist unvollständig oder enthält einen Wert, der keine Zahl ist.",
    "file.rows_and_header": "Die Datei enthält keine Messwerte, oder ihre Zeilen sind nicht so lang wie ihr Kopf.",
    "file.samples_and_times": "Die Datei hat {samples:number} Messwerte und {times:number} Zeitstempel; sie ist"
    " beschädigt.",
    "file.sensor_not_finite": "{where:place}: Einige Werte sind nicht endlich; füllen oder schneiden Sie diese"
    " Lücken zuerst.",
    "file.sensor_not_numeric": "Sensor {name}: `{key}` fehlt oder enthält keine Zahlen.",
    "file.sensor_shape": "Sensor {name}: `{key}` hat die Form {shape}; {samples} Zeitstempel brauchen {expected}.",
    "file.time_backwards": "In Zeile {row} läuft die Zeit rückwärts; sortieren Sie die Zeilen nach der Zeit.",
    "file.time_stamps_differ": "Die Sensoren haben verschiedene Zeitstempel; bringen Sie sie auf eine Zeitspalte.",
    "file.time_stands_still": "In Zeile {row} geht die Zeit nicht weiter; entfernen Sie wiederholte Zeilen.",
    "file.time_unit": "In {unit} gelesen ergibt die Zeitspalte {rate_hz:number~3} Zeilen pro Sekunde; möglich"
    " sind {lowest_hz:number} bis {highest_hz:number}. {advice}",
    "file.sensor_name": "Ein Sensor kann nicht {names:or} heißen: Möglich sind Buchstaben, Ziffern, Leerzeichen, _,"
    " - und ., ein Buchstabe oder eine Ziffer zuerst. Benennen Sie ihn in der Datei um.",
    "file.too_few_rows": "Die Datei enthält weniger als zwei Zeilen; es gibt nichts auszuwerten.",
    "file.too_long": "Die Datei ist zu lang; teilen Sie sie in kürzere Aufzeichnungen.",
    "file.uneven": "Die Messwerte liegen zeitlich nicht gleichmäßig; rechnen Sie sie zuerst auf eine Rate um.",
    "file.unpacks_to_too_much": "Die Datei hat {packed_bytes:mib.1} und wird entpackt größer als"
    " {limit_bytes:mib~4}, das Höchste, was auf einmal gelesen wird; teilen Sie die Aufzeichnung.",
    "file_kind.broad": "ein Versuch des BROAD-Vergleichs",
    "file_kind.gaitmap": "eine Aufzeichnung der gaitmap-Bibliothek",
    "file_kind.pyshoe": "ein Gang aus dem PyShoe-Satz",
    "file_kind.qmt": "eine Ganzkörperaufzeichnung der qmt-Toolbox",
    "findings.also_outside": "Außerdem außerhalb des Bandes: {angles:and}.",
    "findings.beyond_angle": "{channel:channel} (um bis zu {beyond_rad:deg})",
    "findings.beyond_length": "{channel:channel} (um bis zu {beyond_m:cm})",
    "findings.faster": "Jede Wiederholung war schneller als in der Vorlage ({value_s:s.1} gegenüber"
    " {reference_s:s.1}).",
    "findings.how_often": {
        "one": "Das lag außerhalb des Bandes.",
        "other": "Das lag in {outside:number} von {count:number} Wiederholungen außerhalb des Bandes.",
    },
    "findings.in_phases": "Meist in: {phases:and}.",
    "findings.less_smooth": "Die Bewegung war weniger flüssig als in der Vorlage (Bewegungsfluss"
    " {value:number.1} gegenüber {reference:number.1}).",
    "findings.longer_way": "Der Weg der Hand war {more:percent} länger als in der Vorlage.",
    "findings.matched": "Die Bewegung entsprach der Vorlage, soweit sich das messen lässt.",
    "findings.no_difference": "Kein Unterschied zur Vorlage ist größer als die Messunsicherheit.",
    "findings.no_strides": "In dieser Sitzung wurde kein Doppelschritt von einem Auftritt zum nächsten gefunden.",
    "findings.no_stride_used": "Es wurden Doppelschritte gefunden, aber alle ausgeschlossen; der Grund steht jeweils"
    " daneben.",
    "findings.none_found": "In dieser Sitzung wurden keine eindeutigen Wiederholungen gefunden.",
    "findings.none_used": "Es wurden Wiederholungen gefunden, aber alle ausgeschlossen; der Grund steht jeweils"
    " daneben.",
    "findings.others_outside": "Außerhalb des Bandes: {angles:and}.",
    "findings.outside": {
        "one": "{channel:channel}: außerhalb des Bandes, um bis zu {beyond_rad:deg}.",
        "other": "{channel:channel}: in {outside:number} von {count:number} Wiederholungen außerhalb des"
        " Bandes, um bis zu {beyond_rad:deg}.",
    },
    "findings.outside_length": {
        "one": "{channel:channel}: außerhalb des Bandes, um bis zu {beyond_m:cm}.",
        "other": "{channel:channel}: in {outside:number} von {count:number} Wiederholungen außerhalb des"
        " Bandes, um bis zu {beyond_m:cm}.",
    },
    "findings.this_outside_mostly": {
        "one": "Das lag außerhalb des Bandes, meist zwischen {start:points} und {end:percent} der Bewegung.",
        "other": "Das lag in {outside:number} von {count:number} Wiederholungen außerhalb des Bandes, meist"
        " zwischen {start:points} und {end:percent} der Bewegung.",
    },
    "findings.places_followed": "Damit war auch der Arm woanders: {angles:and}.",
    "findings.main_not_measured": "{channel:channel}, die wichtigste Messgröße dieser Übung, wurde nicht gemessen."
    " Darüber lässt sich nichts sagen: Legen Sie die Sensoren über und unter dem Gelenk an, und kalibrieren Sie sie.",
    "findings.main_mostly_not_measured": "{channel:channel}, die wichtigste Messgröße dieser Übung, wurde die meiste"
    " Zeit nicht gemessen: nur in {share:percent} der Bewegung. Prüfen Sie die Sensoren über und unter dem Gelenk.",
    "findings.main_uncertain": "{channel:channel}, die wichtigste Messgröße dieser Übung, wurde für einen Vergleich"
    " nicht genau genug gemessen: nur auf {unsure_rad:deg} genau.",
    "findings.outside_mostly": {
        "one": "{channel:channel}: außerhalb des Bandes, meist zwischen {start:points} und {end:percent} der"
        " Bewegung.",
        "other": "{channel:channel}: in {outside:number} von {count:number} Wiederholungen außerhalb des"
        " Bandes, meist zwischen {start:points} und {end:percent} der Bewegung.",
    },
    "findings.range_larger": "{channel:channel}: Der Umfang war um {difference_rad:deg} größer als in der"
    " Vorlage ({value_rad:deg} gegenüber {reference_rad:deg}).",
    "findings.range_less": "{channel:channel}: Der Umfang war um {difference} kleiner als in der Vorlage ({value}"
    " gegenüber {reference}).",
    "findings.range_more": "{channel:channel}: Der Umfang war um {difference} größer als in der Vorlage ({value}"
    " gegenüber {reference}).",
    "findings.range_smaller": "{channel:channel}: Der Umfang war um {difference_rad:deg} kleiner als in der"
    " Vorlage ({value_rad:deg} gegenüber {reference_rad:deg}).",
    "findings.shoulder_rose": "Ausweichbewegung: Die Schulter hob sich {more_m:cm} mehr als in der Vorlage.",
    "findings.slower": "Jede Wiederholung dauerte {ratio:number.1}\u2011mal so lange wie in der Vorlage"
    " ({value_s:s.1} gegenüber {reference_s:s.1}).",
    "findings.smoother": "Die Bewegung war flüssiger als in der Vorlage (Bewegungsfluss {value:number.1}"
    " gegenüber {reference:number.1}).",
    "findings.some_faster": {
        "one": "Wiederholung {repetitions:and} dauerte nur {value_s:s.1} gegenüber {reference_s:s.1} in der Vorlage.",
        "other": "Wiederholungen {repetitions:and} waren schneller als in der Vorlage: bis hinab zu {value_s:s.1}"
        " gegenüber {reference_s:s.1}.",
    },
    "findings.some_shoulder_rose": {
        "one": "Ausweichbewegung in Wiederholung {repetitions:and}: Die Schulter hob sich {more_m:cm} mehr als in"
        " der Vorlage.",
        "other": "Ausweichbewegung in den Wiederholungen {repetitions:and}: Die Schulter hob sich bis zu"
        " {more_m:cm} mehr als in der Vorlage.",
    },
    "findings.some_slower": {
        "one": "Wiederholung {repetitions:and} dauerte {value_s:s.1} gegenüber {reference_s:s.1} in der Vorlage.",
        "other": "Wiederholungen {repetitions:and} dauerten bis zu {value_s:s.1} gegenüber {reference_s:s.1} in der"
        " Vorlage.",
    },
    "findings.some_smaller": {
        "one": "Wiederholung {repetitions:and} war kleiner als in der Vorlage: {channel:channel} {value_rad:deg}"
        " gegenüber {reference_rad:deg}.",
        "other": "Wiederholungen {repetitions:and} waren kleiner als in der Vorlage: {channel:channel} bis hinab zu"
        " {value_rad:deg} gegenüber {reference_rad:deg}.",
    },
    "findings.some_strides_faster": {
        "one": "Doppelschritt {strides:and} dauerte nur {value_s:s.1} gegenüber {reference_s:s.1} in der Vorlage.",
        "other": "Doppelschritte {strides:and} waren schneller als in der Vorlage: bis hinab zu {value_s:s.1}"
        " gegenüber {reference_s:s.1}.",
    },
    "findings.some_strides_less": {
        "one": "Doppelschritt {strides:and} war kleiner als in der Vorlage: {channel:channel} {value} gegenüber"
        " {reference}.",
        "other": "Doppelschritte {strides:and} waren kleiner als in der Vorlage: {channel:channel} bis hinab zu"
        " {value} gegenüber {reference}.",
    },
    "findings.some_strides_slower": {
        "one": "Doppelschritt {strides:and} dauerte {value_s:s.1} gegenüber {reference_s:s.1} in der Vorlage.",
        "other": "Doppelschritte {strides:and} dauerten bis zu {value_s:s.1} gegenüber {reference_s:s.1} in der"
        " Vorlage.",
    },
    "findings.stride_outside": {
        "one": "{what:foot}: außerhalb des Bandes zwischen {start:points} und {end:percent} des Doppelschritts.",
        "other": "{what:foot}: in {outside:number} von {count:number} Doppelschritten außerhalb des Bandes, meist"
        " zwischen {start:points} und {end:percent} des Doppelschritts.",
    },
    "findings.strides_faster": "Jeder Doppelschritt war schneller als in der Vorlage ({value_s:s.1} gegenüber"
    " {reference_s:s.1}).",
    "findings.strides_slower": "Jeder Doppelschritt dauerte {ratio:number.1}\u2011mal so lange wie in der Vorlage"
    " ({value_s:s.1} gegenüber {reference_s:s.1}).",
    "findings.some_trunk": {
        "one": "Ausweichbewegung in Wiederholung {repetitions:and}: {channel:channel} {more_rad:deg} mehr als in"
        " der Vorlage.",
        "other": "Ausweichbewegung in den Wiederholungen {repetitions:and}: {channel:channel} bis zu {more_rad:deg}"
        " mehr als in der Vorlage.",
    },
    "foot.faster": "der Fuß ging schneller vorwärts als in der Vorlage",
    "foot.higher": "der Fuß wurde mehr gehoben als in der Vorlage",
    "foot.lower": "der Fuß wurde weniger gehoben als in der Vorlage",
    "foot.slower": "der Fuß ging langsamer vorwärts als in der Vorlage",
    "foot.toes_higher": "die Zehen zeigten weiter nach oben als in der Vorlage",
    "foot.toes_lower": "die Zehen zeigten weiter nach unten als in der Vorlage",
    "size.angle": "{value_rad:deg}",
    "size.length": "{value_m:cm.1}",
    "size.speed": "{value_mps:mps}",
    "findings.trunk_leaned_forward": "Ausweichbewegung: Der Rumpf neigte sich {more_rad:deg} mehr als in der"
    " Vorlage, vor und zurück ({value_rad:deg} gegenüber {reference_rad:deg}).",
    "findings.trunk_leaned_sideways": "Ausweichbewegung: Der Rumpf neigte sich {more_rad:deg} mehr als in der"
    " Vorlage, zur Seite ({value_rad:deg} gegenüber {reference_rad:deg}).",
    "findings.trunk_turned": "Ausweichbewegung: Der Rumpf drehte sich {more_rad:deg} mehr als in der Vorlage"
    " ({value_rad:deg} gegenüber {reference_rad:deg}).",
    "gaitmap.header": "Die Datei braucht einen Kopf aus einer oder zwei Zeilen, mit Zahlen darunter.",
    "gaitmap.side": "Die Datei sagt nicht, von welchem Fuß sie ist; schreiben Sie `left` oder `right` in ihren"
    " Namen.",
    "gaitmap.strides": "{file} ist keine Liste von Doppelschritten.",
    "grant.end_needs_zone": "Das Ende eines Zugriffsrechts braucht eine Zeitzone, zum Beispiel"
    " 2030-01-31T12:00:00Z.",
    "grant.ends_in_past": "Das Ende eines Zugriffsrechts muss in der Zukunft liegen.",
    "grant.no_account": "Ein solches aktives Konto gibt es in dieser Praxis nicht.",
    "grant.not_found": "Das Zugriffsrecht wurde nicht gefunden, oder es ist nicht für Sie freigegeben.",
    "grant.own_data": "Patientinnen und Patienten sehen ihre eigenen Daten ohne Zugriffsrecht.",
    "guess.foot_side": "Die Tabelle sagt nicht, von welchem Fuß sie ist; angenommen wird der rechte.",
    "guess.left_out": "Nicht verwendet: {columns:and}.",
    "guess.no_gravity": "Die Spalten {columns:and} enthalten Beschleunigung ohne Schwerkraft; exportieren Sie,"
    " was der Beschleunigungssensor gemessen hat.",
    "guess.no_names": "Die Tabelle hat keine Zeile mit den Namen ihrer Spalten; fügen Sie eine hinzu, oder geben"
    " Sie in einer Zuordnung an, welche Spalte was ist.",
    "guess.no_place": "Diese Spalten sagen nicht, wo am Körper der Sensor sitzt: {columns:and}.",
    "guess.no_signal": "Keine drei Spalten sind als x, y und z einer Drehrate oder Beschleunigung benannt.",
    "guess.counter": "{column} zählt die Messwerte, mit {rate_hz:hz.1}; wo der Zähler springt, fehlen"
    " Messwerte.",
    "guess.clocks_left": "Auch {columns:and} enthalten Zeiten; genommen wurde {column}.",
    "guess.microseconds": "{column} zählt, so die Annahme, Mikrosekunden; die Zeilen kommen mit {rate_hz:hz.1}.",
    "guess.time_unit": "{column} nennt keine Zeiteinheit; angenommen wird {unit}, also kommen die Zeilen mit"
    " {rate_hz:hz.1}.",
    "guess.counter_needs_rate": "Keine Spalte ist eine Zeit; {column} zählt die Messwerte. Geben Sie die Rate an.",
    "guess.rate_left": "Eine Zeile über der Tabelle, oder Sie, sagten {said_hz:hz}; nach {column} kommen die"
    " Zeilen mit {rate_hz:hz}. Die Spalte wurde genommen.",
    "guess.rows_counted": "Keine Spalte ist eine Zeit: Die Zeilen folgen einander, so die Annahme, mit"
    " {rate_hz:hz}. Fehlende Zeilen fielen nicht auf.",
    "guess.one_device": "Die Spalte {column} wechselt ({values:and}), und keine zwei davon liefen zugleich: alle Zeilen"
    " gelten als eine Aufnahme derselben Sensoren.",
    "guess.devices": "Die Zeilen sind von mehreren Geräten, unterschieden durch {column}: {values:and}.",
    "guess.tall": "Jede Zeile hat einen Wert; wovon, sagt {columns:and}. Die Werte einer Messung werden nebeneinander"
    " gestellt.",
    "guess.tall_unsorted": "Jede Zeile hat einen Wert, und am Anfang der Tabelle steht nur {values:and}; ein Sensor"
    " braucht drei Achsen einer Drehrate und einer Beschleunigung. Sortieren Sie die Zeilen nach {column}, damit jede"
    " Messung beisammen steht.",
    "guess.tall_lacks": "Jede Zeile hat einen Wert, und am Anfang der Tabelle steht nur {values:and}; ein Sensor"
    " braucht drei Achsen einer Drehrate und einer Beschleunigung.",
    "table.rows_of_no_signal": {
        "one": "Eine Zeile bleibt weg: {values:and} steht am Anfang der Tabelle nicht in {column}.",
        "other": "{count:number} Zeilen bleiben weg: {values:and} steht am Anfang der Tabelle nicht in {column}.",
    },
    "guess.own_clocks": "Die Sensoren haben eigene Uhren: {columns:and}. Sie zählen, so die Annahme, vom selben"
    " Moment an.",
    "guess.no_time": "Keine Spalte ist eine Zeit, und keine Zeile über der Tabelle nennt eine Rate; geben Sie"
    " die Rate an.",
    "guess.no_unit": "Die Spalten {columns:and} nennen keine Einheit, und mit einer Größe von {size:number~3}"
    " sind ihre Zahlen weder m/s² noch g noch mg; rechnen Sie sie zuerst um.",
    "guess.not_whole": "Kein Sensor hat sowohl eine Drehrate als auch eine Beschleunigung; beides ist nötig.",
    "guess.orientation_only": "Die Tabelle enthält Orientierungen ({columns:and}), nicht was die Sensoren"
    " messen; exportieren Sie auch Drehrate und Beschleunigung.",
    "guess.unit_of_others": "Die Spalten {columns:and} nennen keine Einheit, und auch ihre Zahlen verraten keine;"
    " genommen wird {unit:unit} wie bei den anderen Sensoren.",
    "guess.unit_assumed": "Die Spalten {columns:and} nennen keine Einheit, und auch ihre Zahlen verraten keine;"
    " angenommen wird {unit:unit}.",
    "guess.field_relative": "Die Spalten {columns:and} nennen keine Einheit und sind etwa von der Größe eins: Sie"
    " gelten als Vielfache des Feldes, in dem das Magnetometer kalibriert wurde, etwa 45 µT.",
    "guess.unit_from_numbers": "Die Spalten {columns:and} nennen keine Einheit; ihren Zahlen nach ist es {unit:unit}.",
}
