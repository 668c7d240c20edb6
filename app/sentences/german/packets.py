"""German sentences of packets, passwords, patients, places, prescriptions and progress."""

from typing import Final

GERMAN: Final[dict[str, str | dict[str, str]]] = {
    "packet.absurd": "Takt {tick} von Sensor {sensor} enthält einen Wert über {limit}; senden Sie SI-Einheiten.",
    "packet.all_or_none": "Geben Sie {channel} für alle Sensoren an oder für keinen.",
    "packet.channels_missing": "Die Schätzung braucht Gyroskop und Beschleunigungssensor; setzen Sie die Bits 0"
    " und 1 der Kanalmaske.",
    "packet.crc": "Die CRC-32 über die Kopfbytes 0 bis 27 und die Nutzdaten stimmt nicht; senden Sie das Paket"
    " noch einmal.",
    "packet.encoding": "Die Kodierung {encoding} ist unbekannt; verwenden Sie 0 (float32) oder 1 (int16).",
    "packet.flags": "Die Flags {flags} haben unbekannte Bits; es gibt nur die Bits 0 und 1.",
    "packet.interval": "Ein Taktabstand von {interval_us} µs ist nicht möglich; senden Sie {least_us} bis"
    " {most_us} µs.",
    "packet.interval_declared": "Ein Taktabstand von {interval_us} µs passt nicht zu den angegebenen"
    " {rate_hz:hz~4}; der Abstand ist in Mikrosekunden.",
    "packet.json_too_long": "Eine JSON-Nachricht darf {limit_bytes:kib} haben; senden Sie binäre Pakete.",
    "packet.length": "Das Paket hat {size} Bytes; {sensors} Sensoren, {ticks} Takte und Kanalmaske {mask}"
    " brauchen {expected}. Prüfen Sie die Anzahlen im Kopf.",
    "packet.magic": "Die Nachricht beginnt nicht mit BNP1: Sie ist kein Paket eines Körpernetzes.",
    "packet.mask": "Die Kanalmaske {mask} ist leer oder hat unbekannte Bits; es gibt die Bits 0 bis 7.",
    "packet.mask_scale": "Die Kanalmaske {mask} hat Kanäle ohne angegebene Skala; senden Sie diese als float32.",
    "packet.not_finite": "Takt {tick} von Sensor {sensor} enthält einen Wert, der nicht endlich ist. Senden Sie"
    " Nullen in allen Kanälen für einen Sensor, der nichts geliefert hat.",
    "packet.not_understood": "Die Nachricht ist nicht gültig: {faults}",
    "packet.nothing_right": "Lange Zeit kam keine gültige Nachricht; siehe docs/packet.md.",
    "packet.reserved": "Die reservierten Bytes 10 und 11 müssen in Version 1 null sein.",
    "packet.scale": "Zählwerte brauchen {field} im Hello; geben Sie es an, oder senden Sie float32.",
    "packet.sensors": "{sensors} Sensoren sind nicht möglich; senden Sie 1 bis {most}.",
    "packet.sensors_declared": "Das Paket hat {sensors} Sensoren, das Hello hat {declared} angegeben; senden Sie"
    " ein neues Hello, wenn sich das Netz ändert.",
    "packet.sequence_jump": "Die laufende Nummer liegt {steps} vor der neuesten; zählen Sie Pakete einzeln.",
    "packet.sequence_reused": "Diese laufende Nummer wurde für ein anderes Paket benutzt; fahren Sie nach einem"
    " Neustart hinter dem bestätigten `highest` fort.",
    "packet.shape": "Sensor {sensor} muss in jedem Kanal {ticks} Zeilen mit drei Werten haben wie Sensor 0 (bei"
    " Spulenzuständen: so viele Zahlen).",
    "packet.ticks": "{ticks} Takte sind nicht möglich; senden Sie 1 bis {most}.",
    "packet.time_ahead": "Die Gerätezeit {time_us} µs liegt {gap_s:s} vor dem Paket davor. Wurde die Geräteuhr"
    " zurückgesetzt, verbinden Sie mit einem neuen Hello.",
    "packet.time_before": "Die Gerätezeit {time_us} µs liegt vor dem Ende des Pakets davor. Wurde die Geräteuhr"
    " zurückgesetzt, verbinden Sie mit einem neuen Hello.",
    "packet.time_later": "Die Gerätezeit {time_us} µs ist später als die einer höheren laufenden Nummer. Wurde"
    " die Geräteuhr zurückgesetzt, verbinden Sie mit einem neuen Hello.",
    "packet.too_long": "Ein Paket von {size} Bytes ist zu lang; senden Sie höchstens {most}.",
    "packet.truncated": "Das Paket hat {size} Bytes; allein der Kopf hat {header}. Senden Sie in jeder Nachricht"
    " ein ganzes Paket.",
    "packet.values": "Geben Sie Werte als float32 oder int16 in der Form (Takte, Sensoren, Werte) an.",
    "packet.width": "{width} Werte je Sensor passen nicht zur Kanalmaske {mask}.",
    "password.common": "Dieses Passwort gehört zu den häufigsten; wählen Sie ein anderes, zum Beispiel vier"
    " Wörter.",
    "password.own": "Dieses Passwort besteht aus Ihrem Namen oder Ihrer E-Mail-Adresse; wählen Sie ein anderes,"
    " zum Beispiel vier Wörter.",
    "password.repeats": "Dieses Passwort wiederholt sich; wählen Sie ein anderes, zum Beispiel vier Wörter.",
    "password.row": "Dieses Passwort ist eine Reihe von Buchstaben, Ziffern oder Tasten; wählen Sie ein anderes,"
    " zum Beispiel vier Wörter.",
    "password.short": "Dieses Passwort ist kürzer als {least} Zeichen; wählen Sie ein anderes, zum Beispiel vier"
    " Wörter.",
    "patient.twin": "Es gibt schon eine Akte mit diesem Namen und Geburtsdatum. Öffnen Sie sie, oder sagen Sie, dass"
    " dies eine andere Person ist.",
    "patient.no_name": "Schreiben Sie mindestens einen Namen.",
    "patient.merge_itself": "Wählen Sie eine andere Akte als diese.",
    "patient.merged_before": "Diese Akte wurde schon mit einer anderen zusammengeführt und ist leer.",
    "patient.archive_first": "Archivieren Sie die Akte zuerst; Löschen lässt sich nicht rückgängig machen.",
    "patient.archived": "Diese Akte ist archiviert: Vorhandene Daten sind lesbar, nichts kann hinzugefügt werden.",
    "patient.being_analysed": "Eine Aufzeichnung dieser Person wird gerade ausgewertet; versuchen Sie es in"
    " einer Minute erneut.",
    "patient.consent_withdrawn": "Die Einwilligung in die Behandlung wurde zurückgezogen: Vorhandene Daten sind"
    " lesbar, nichts kann hinzugefügt werden.",
    "patient.create_not_allowed": "Nur Therapie und Verwaltung können Akten anlegen.",
    "patient.level": "Ihr Zugriff auf diese Akte umfasst das nicht; nötig ist das Recht: {level:level}.",
    "patient.no_consent": "Noch ist nicht eingetragen, dass die Person in die Behandlung einwilligt. Fragen Sie"
    " sie, und tragen Sie die Antwort auf ihrer Seite unter Einwilligung ein.",
    "patient.no_home_consent": "Die Person hat nicht in das Aufzeichnen zu Hause eingewilligt. Tragen Sie die"
    " Einwilligung zuerst auf ihrer Seite ein.",
    "patient.not_found": "Diese Akte wurde nicht gefunden, oder sie ist nicht für Sie freigegeben.",
    "patient.session_live": "Eine Sitzung dieser Person ist live; beenden Sie sie zuerst.",
    "place.foot_left": "Fuß links",
    "place.foot_right": "Fuß rechts",
    "place.forearm_left": "Unterarm links",
    "place.forearm_right": "Unterarm rechts",
    "place.forefoot_left": "Vorfuß links",
    "place.forefoot_right": "Vorfuß rechts",
    "place.hand_left": "Hand links",
    "place.hand_right": "Hand rechts",
    "place.head": "Kopf",
    "place.heel_left": "Ferse links",
    "place.heel_right": "Ferse rechts",
    "place.pelvis": "Becken",
    "place.shank_left": "Unterschenkel links",
    "place.shank_right": "Unterschenkel rechts",
    "place.shoulder_left": "Schulter links",
    "place.shoulder_right": "Schulter rechts",
    "place.sternum": "Brust",
    "place.thigh_left": "Oberschenkel links",
    "place.thigh_right": "Oberschenkel rechts",
    "place.upper_arm_left": "Oberarm links",
    "place.upper_arm_right": "Oberarm rechts",
    "placement.arms_swapped": "Die Sensoren des linken und des rechten Arms sind vertauscht. Jeden an seinen"
    " Platz setzen und wiederholen.",
    "placement.back_to_front": "{where:place}: Der Sensor saß verkehrt herum (vorn und hinten vertauscht), denn"
    " Gelenke beugten sich falsch herum. Seine Richtung wurde um eine halbe Drehung gewendet; damit sind die Winkel"
    " berechnet.",
    "placement.faced_away": "{where:place}: Der Sensor zeigte {angle_rad:deg} von der angenommenen Richtung weg."
    " Die Blickrichtung wurde daraus bestimmt, wie sich die Gelenke beugten, auf etwa {sigma_rad:deg}. Eine"
    " Kalibrierung durch Bewegung misst sie.",
    "placement.elbow_impossible": "Ellbogen {side:side}: Er zeigte {angle_rad:deg}, das ist nicht möglich. Entweder"
    " hing der Arm in der Kalibrierhaltung nicht gestreckt (zum Beispiel im Sitzen mit gebeugten Ellbogen), oder"
    " ein Sensor sitzt verkehrt herum: {where:place}. Die Winkel dieses Arms werden nicht angegeben. Kalibrieren"
    " Sie erneut im Stehen mit hängenden Armen oder durch Bewegung.",
    "placement.knee_impossible": "Knie {side:side}: Es zeigte {angle_rad:deg}, das ist nicht möglich. Entweder war"
    " das Bein in der Kalibrierhaltung nicht gestreckt (zum Beispiel im Sitzen), oder ein Sensor sitzt verkehrt"
    " herum: {where:place}. Die Winkel dieses Beins werden nicht angegeben. Kalibrieren Sie erneut im aufrechten"
    " Stehen.",
    "placement.arm_behind": "Arm {side:side}: Er schien sich hinter den Rücken oder durch den Rumpf zu heben, das"
    " ist nicht möglich. Entweder sitzt ein Sensor verkehrt herum, oder Sensoren beider Seiten sind vertauscht:"
    " {where:place}. Die Winkel dieses Arms werden nicht angegeben. Prüfen Sie die Sensoren, und kalibrieren Sie"
    " erneut.",
    "placement.arm_unclear": "Arm {side:side}: Nach dem Beugen des Ellbogens sitzt ein Sensor um {angle_rad:deg}"
    " anders, als er angelegt werden soll, oder der Arm hing in der Kalibrierhaltung nicht gestreckt:"
    " {where:place}. Die Winkel dieses Arms werden nicht angegeben. Legen Sie die Sensoren mit der bedruckten Seite"
    " nach außen an, und kalibrieren Sie erneut im Stehen mit hängenden Armen oder durch Bewegung.",
    "placement.trunk_backward": "{where:place}: Der Rumpf schien sich von den hängenden Armen weiter nach hinten zu"
    " neigen, als Schultern es zulassen. Der Sensor sitzt wahrscheinlich verkehrt herum. Die Winkel von Rumpf und"
    " Schultern werden nicht angegeben. Drehen Sie die bedruckte Seite nach vorn, und kalibrieren Sie erneut.",
    "placement.bent_aside": "Seite {side:side}: Ein Gelenk schien sich {angle_rad:deg} neben der Richtung zu"
    " beugen, in die es sich beugen kann. Vielleicht zeigt die bedruckte Seite eines Sensors nicht nach außen:"
    " {where:place}. Die Winkel dieses Arms oder Beins werden nicht angegeben. Prüfen Sie die Sensoren, und"
    " kalibrieren Sie erneut oder durch Bewegung.",
    "placement.half_turn": "{where:place}: Der Sensor ist um eine halbe Drehung verdreht, die bedruckte Seite"
    " zum Körper. Die Kalibrierung berücksichtigt das, aber prüfen Sie, ob es der richtige Sensor ist.",
    "placement.half_turn_since": "{where:place}: Der Sensor ist seit dem letzten Mal um eine halbe Drehung"
    " verdreht. Das ist erlaubt, aber prüfen Sie, ob es der richtige Sensor ist.",
    "placement.moved_since": "{where:place}: Der Sensor sitzt um {angle_rad:deg} anders als beim letzten Mal.",
    "placement.segments_swapped": "Die Sensoren sind vertauscht: {where:place}. Jeden an seinen Platz setzen und"
    " wiederholen.",
    "placement.twins_swapped": "Die Sensoren sind vertauscht ({where:place}), oder die bedruckten Seiten beider"
    " zeigen zum Körper. Prüfen Sie sie.",
    "placement.wrong_arm": "Arm {side:side}: Die so benannten Sensoren haben sich bewegt wie die des anderen"
    " Arms. Seite prüfen und wiederholen.",
    "prescription.ends_before_start": "Eine Verordnung muss nach ihrem Beginn enden.",
    "prescription.no_such_template": "Eine solche Vorlage gibt es für diese Übung und diese Person nicht.",
    "prescription.not_found": "Die Verordnung wurde nicht gefunden, oder sie ist nicht für Sie freigegeben.",
    "prescription.time_needs_zone": "Eine Zeit braucht ihre Zeitzone, zum Beispiel 2030-01-31T12:00:00Z.",
    "progress.checking": "Einheiten und Achsen werden geprüft",
    "progress.comparing": "Vergleich mit der Vorlage",
    "progress.estimating": "Bewegung wird geschätzt",
    "progress.estimator": "Schätzverfahren {estimator} {version}, Auswertung {pipeline}",
    "progress.feet": "Den Füßen wird gefolgt",
    "progress.forces": "Kräfte und Gleichgewicht",
    "progress.fusing": "Marker werden abgeglichen und zusammengeführt",
    "progress.norm_confidence": "Gesunde von {first} bis {last} Jahren, Mittel mit 95-%-Intervall ({source})",
    "progress.norm_means": "Mittelwerte gesunder Männer und Frauen von {first} bis {last} Jahren ({source})",
    "progress.other_side": {
        "one": "Andere Seite ({side:side}), neueste Sitzung, 1 Wiederholung",
        "other": "Andere Seite ({side:side}), neueste Sitzung, Mittel aus {count}",
    },
    "progress.pain": "Abgebrochen, weil es wehtat",
    "progress.prescribed": "Verordnet: {dose}",
    "progress.reading_file": "Datei wird gelesen",
    "progress.reading_markers": "Marker werden gelesen",
    "progress.reading_walk": "Gang wird gelesen",
    "progress.smoothing": "Bewegung wird geschätzt, vorwärts und rückwärts",
    "progress.storing": "Aufzeichnung wird gespeichert",
    "progress.template": "Vorlage {name}, Version {number}",
    "quantity.accelerometer": "Beschleunigungssensor",
    "quantity.gyroscope": "Gyroskop",
    "quantity.magnetometer": "Magnetometer",
}
