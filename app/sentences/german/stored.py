"""German sentences of what is stored, tables, templates and times."""

from typing import Final

GERMAN: Final[dict[str, str | dict[str, str]]] = {
    "stored.already": "Einige dieser Pakete sind schon gespeichert.",
    "stored.behind": "Das Speichern ist im Rückstand; behalten Sie das Paket, und senden Sie es noch einmal.",
    "stored.checksum": "Gespeicherte Daten sind beschädigt (falsche Prüfsumme); stellen Sie sie aus einer"
    " Sicherung wieder her.",
    "stored.codec": "Gespeicherte Daten stammen von einer neueren Version des Dienstes (Codec {codec});"
    " installieren Sie diese Version.",
    "stored.comparison": "Vergleich",
    "stored.cut_off": "Gespeicherte Daten sind abgeschnitten oder beschädigt; stellen Sie sie aus einer"
    " Sicherung wieder her.",
    "stored.failed": "Diese Sitzung kann nicht mehr gespeichert werden. {reason}",
    "stored.layout": "Gespeicherte Bewegungsdaten passen nicht zur Anordnung ihres Ergebnisses; stellen Sie sie"
    " aus einer Sicherung wieder her.",
    "stored.length": "Gespeicherte Daten haben {found} Bytes statt {expected}; stellen Sie sie aus einer"
    " Sicherung wieder her.",
    "stored.not_encoded": "Ihre Daten können nicht kodiert werden ({error}).",
    "stored.not_open": "Diese Sitzung ist nicht zum Speichern geöffnet; öffnen Sie sie zuerst.",
    "stored.other_process": "Auch ein anderer Prozess speichert diese Sitzung; eine Sitzung gehört immer nur"
    " einem Server.",
    "stored.packet_empty": "Ein Paket braucht mindestens einen Takt von mindestens einem Sensor.",
    "stored.packet_encoding": "Die Paketkodierung {encoding} ist unbekannt; verwenden Sie 0 (float32) oder 1"
    " (Zählwerte).",
    "stored.packet_payload": "Nutzdaten von {size} Bytes lassen sich nicht in {ticks} Takte teilen.",
    "stored.packet_range": "Laufende Nummer oder Gerätezeit liegt außerhalb des Bereichs.",
    "stored.quota": "Ihre Praxis hat {used_bytes:gib.1} an Signalen gespeichert; erlaubt sind"
    " {limit_bytes:gib.1}. Löschen Sie Sitzungen, die nicht mehr gebraucht werden, oder bitten Sie den"
    " Betrieb dieses Dienstes um mehr.",
    "stored.no_room": "Diese Datei von {size_bytes:mib.1} passt nicht: Ihre Praxis hat {used_bytes:mib.1} gespeichert,"
    " Hochgeladenes darf {limit_bytes:mib.1} belegen; der Rest bleibt für laufende Sitzungen frei. Löschen Sie"
    " Sitzungen, die nicht mehr gebraucht werden, oder bitten Sie den Betrieb dieses Dienstes um mehr.",
    "stored.disk_reserve": "Auf der Platte dieses Dienstes ist für weitere Dateien kein Platz; der Rest bleibt für"
    " laufende Sitzungen frei. Fragen Sie den Betrieb dieses Dienstes und senden Sie die Datei später noch einmal.",
    "stored.refused": "Die Datenbank hat ihre Daten abgewiesen.",
    "stored.session_gone": "Die Sitzung gibt es nicht mehr.",
    "stored.stopping": "Der Dienst hält gerade an; senden Sie noch einmal an den nächsten.",
    "stored.template": "Vorlage",
    "stored.undecodable": "Gespeicherte Daten lassen sich nicht entpacken; stellen Sie sie aus einer Sicherung"
    " wieder her.",
    "table.commas_twice": "Die Zahlen haben Dezimalkommas, und auch zwischen ihnen stehen Kommas: Was davon was"
    " ist, lässt sich nicht feststellen. Speichern Sie die Tabelle mit Strichpunkten oder Tabulatoren"
    " zwischen den Spalten.",
    "table.empty": "Die Datei enthält nichts, was eine Tabelle sein könnte.",
    "table.endless_line": "Die erste Zeile hat kein Ende; das ist keine Tabelle.",
    "table.in_columns": "{reason} (In der Datei: {columns:and}.)",
    "table.no_column": "In der Datei fehlt die Spalte {missing:and}. Sie hat: {present}. Berichtigen Sie die"
    " Zuordnung.",
    "table.no_rows": "Die Datei hat einen Kopf, aber keine Zeilen.",
    "table.rows_of_none": {
        "one": "Eine Zeile ist weggelassen: Kein Sensor heißt in {column} {values:and}.",
        "other": "{count:number} Zeilen sind weggelassen: Kein Sensor heißt in {column} {values:and}.",
    },
    "table.rows_of_nobody": {
        "one": "Eine Zeile ist weggelassen: {column} sagt dort nichts.",
        "other": "{count:number} Zeilen sind weggelassen: {column} sagt dort nichts.",
    },
    "table.counters_apart": "Die Zähler von {where:and} beginnen bei anderen Zahlen als der erste; ihre Messwerte"
    " gelten als von der Zeit der Zeilen daneben.",
    "file.slow": "{rate_hz:hz.1} sind weniger als die {least_hz:hz}, die eine Orientierung braucht: Was sich zwischen"
    " zwei Messwerten dreht, ist nicht zu sehen. Die Winkel gelten nur für langsame Bewegung; bei schnellerer sind sie"
    " um mehr als die angegebene Unsicherheit falsch.",
    "table.joined": "Die Größen von {where:place} haben eigene Zeiten; sie werden nach der Zeit zusammengeführt.",
    "table.clocks_apart": "Die Uhren von {where:and} haben keine Zeit gemeinsam: Zwei von ihnen waren nie zugleich"
    " an. Laden Sie jeden Sensor für sich hoch, oder wählen Sie eine Uhr für alle.",
    "table.sensors_joined": "Die Zeiten von {where:and} sind verschieden; alle werden auf eine gebracht.",
    "time.pauses": {
        "one": "Die Aufzeichnung macht eine Pause von {longest_s:s}; dazwischen ist nichts bekannt.",
        "other": "Die Aufzeichnung macht {count:number} Pausen, die längste {longest_s:s}; dazwischen ist nichts"
        " bekannt.",
    },
    "file.averaged_down": "{from_hz:hz} sind mehr, als Bewegung braucht: Ausgewertet werden die Mittel von je"
    " {count:number} Messwerten, mit {rate_hz:hz}.",
    "table.no_field": "{where:place}: Das Magnetometer wird nicht verwendet; in {columns:and} stehen keine Zahlen.",
    "table.iron": "{where:place}: Der Kompass wurde nie kalibriert. Eisen von {field_t:ut} am Gerät wurde aus seinen"
    " Drehungen gefunden und abgezogen.",
    "table.not_a_number_in_line": "Zeile {line:number}: Der Wert in der Spalte {column} ist keine Zahl; die Spalten der"
    " Zuordnung dürfen nur Zahlen enthalten.",
    "table.not_a_number": "Ein Wert in der Spalte {column} ist keine Zahl; die Spalten der Zuordnung dürfen nur"
    " Zahlen enthalten.",
    "table.not_text": "Die Datei ist kein Text: Sie enthält Bytes, die keine Tabelle hat. Speichern Sie sie als"
    " CSV, und versuchen Sie es erneut.",
    "table.not_utf8": "Die Datei ist kein UTF-8-Text. Speichern Sie sie als CSV in UTF-8, und laden Sie sie noch"
    " einmal hoch.",
    "table.ragged": "Viele Zeilen haben eine andere Zahl von Spalten als der Kopf; die Datei ist beschädigt.",
    "table.rows_left_out": {
        "one": "Eine Zeile hat eine andere Zahl von Spalten als der Kopf und ist weggelassen.",
        "other": "{count:number} Zeilen haben eine andere Zahl von Spalten als der Kopf und sind weggelassen.",
    },
    "table.too_long": "Die Datei enthält mehr als {rows:number} Zeilen bei {columns:number} Spalten; teilen Sie"
    " sie in kürzere Aufzeichnungen.",
    "table.too_many_columns": "Die Tabelle hat {columns:number} Spalten; gelesen werden höchstens {most:number}.",
    "table.unreadable": "Die Datei ist nicht als Tabelle lesbar; prüfen Sie das Zeichen zwischen ihren Spalten.",
    "template.by_hand": "Von Hand ausgeschlossen.",
    "template.create_not_allowed": "Nur die Therapie kann Vorlagen erstellen.",
    "template.no_angle": "In dieser Sitzung wurde kein Gelenkwinkel gemessen; kalibrieren Sie die Sensoren am"
    " Körper, und zeichnen Sie noch einmal auf.",
    "template.no_base": "Diese Version gehört zu einer anderen Vorlage; laden Sie die Seite neu, und ändern Sie"
    " die neueste.",
    "template.no_repetition": "Die Nummer {number} gibt es in dieser Aufzeichnung nicht.",
    "template.not_found": "Die Vorlage wurde nicht gefunden, oder sie ist nicht für Sie freigegeben.",
    "template.other_angle": "{name} wurde in dieser Vorlage nicht aufgezeichnet; wählen Sie eine Übung mit einem"
    " ihrer Winkel.",
    "template.other_exercise": "Eine weitere Version muss zu derselben Übung und derselben Person gehören wie"
    " ihre Vorlage.",
    "template.not_walked": "Diese Übung ist ein Gang; wählen Sie die Aufzeichnung eines Gangs.",
    "template.few_strides": {
        "one": "Nur ein Doppelschritt ist brauchbar. Zeichnen Sie einen Gang geradeaus auf, mindestens vier"
        " Doppelschritte mit jedem Fuß.",
        "other": "{count:number} Doppelschritte sind brauchbar. Zeichnen Sie einen Gang geradeaus auf, mindestens vier"
        " Doppelschritte mit jedem Fuß.",
    },
    "template.other_kind": "Doppelschritte werden mit der Vorlage eines Gangs verglichen, andere Bewegungen mit der"
    " einer Bewegung; wählen Sie eine Vorlage derselben Art.",
    "template.other_patient": "Diese Vorlage wurde für eine andere Person gemacht.",
    "template.retired": "„{name}“ ist zurückgezogen; bieten Sie sie unter Vorlagen wieder an, oder wählen Sie"
    " eine andere.",
    "text.lines": "{lines:lines}",
    "time.clock_changed": {
        "one": "Die Zeiten haben keine Zone und springen an einer vollen Stunde um eine Stunde: Angenommen"
        " wird, dass dort die Uhr umgestellt wurde. Wenn die Aufzeichnung stattdessen eine Stunde ruhte,"
        " schreiben Sie die Zeiten mit ihrer Zone.",
        "other": "Die Zeiten haben keine Zone und springen {count:number}\u2011mal an einer vollen Stunde um eine"
        " Stunde: Angenommen wird, dass dort die Uhr umgestellt wurde. Wenn die Aufzeichnung stattdessen eine"
        " Stunde ruhte, schreiben Sie die Zeiten mit ihrer Zone.",
    },
    "time.does_not_advance": "Die Zeitspalte geht nicht weiter; wählen Sie eine andere, oder geben Sie"
    " stattdessen die Rate an.",
    "time.hopeless": "{count:number} von {rows:number} Zeilen haben keine brauchbare Zeit; wählen Sie eine"
    " andere Zeitspalte, oder geben Sie stattdessen die Rate an.",
    "time.midnight": {
        "one": "Die Uhrzeiten haben kein Datum und gehen einmal über Mitternacht; dort wird der nächste Tag"
        " angenommen.",
        "other": "Die Uhrzeiten haben kein Datum und gehen {count:number}\u2011mal über Mitternacht; dort wird"
        " jeweils der nächste Tag angenommen.",
    },
    "time.missing": {
        "one": "Eine Zeile hat keine Zeit und ist weggelassen.",
        "other": "{count:number} Zeilen haben keine Zeit und sind weggelassen.",
    },
    "time.out_of_order": {
        "one": "Die Zeit einer Zeile liegt hinter der einer früheren; sie ist weggelassen.",
        "other": "Die Zeit von {count:number} Zeilen liegt hinter der einer früheren; sie sind weggelassen.",
    },
    "time.counter_holes": {
        "one": "Nach dem Zähler fehlt ein Messwert; dort ist eine Lücke in der Zeit.",
        "other": "Nach dem Zähler fehlen {count:number} Messwerte; dort sind Lücken in der Zeit.",
    },
    "time.hour_passed": {
        "one": "Die Zeiten sind Minuten und Sekunden und gehen einmal über die volle Stunde; dort wird die nächste"
        " Stunde angenommen.",
        "other": "Die Zeiten sind Minuten und Sekunden und gehen {count:number} Mal über die volle Stunde; dort wird"
        " jeweils die nächste Stunde angenommen.",
    },
    "table.header_again": {
        "one": "Die Namen der Spalten stehen in Zeile {line:number} noch einmal, wie nach einem Neustart der"
        " Aufzeichnung; diese Zeile wird ausgelassen.",
        "other": "Die Namen der Spalten stehen in {count:number} Zeilen noch einmal, zuerst in Zeile {line:number}, wie"
        " nach Neustarts der Aufzeichnung; diese Zeilen werden ausgelassen.",
    },
    "time.repeated": {
        "one": "Eine Zeile hat die Zeit der vorigen, oder fast; sie bekommt ihren Platz zwischen ihren Nachbarn.",
        "other": "{count:number} Zeilen haben die Zeit der vorigen, oder fast; sie bekommen ihren Platz zwischen ihren"
        " Nachbarn.",
    },
    "time.row_twice": {
        "one": "Eine Zeile wurde zweimal geschrieben; die zweite ist weggelassen.",
        "other": "{count:number} Zeilen wurden zweimal geschrieben; die zweiten sind weggelassen.",
    },
    "time.set_back": {
        "one": "Die Zeit wurde in der Aufzeichnung einmal zurückgestellt; dort wird eine Pause von"
        " {pause_s:s} angenommen.",
        "other": "Die Zeit wurde in der Aufzeichnung {count:number}\u2011mal zurückgestellt; dort wird jeweils eine"
        " Pause von {pause_s:s} angenommen.",
    },
    "joint.trunk": "Rumpf",
    "joint.shoulder": "Schulter",
    "joint.elbow": "Ellbogen",
    "joint.wrist": "Handgelenk",
    "triad.accelerometer": "Beschleunigungssensor",
    "triad.gyroscope": "Gyroskop",
}
