"""German sentences of uploads, of what is shown of a table before, and of the 3D view."""

from typing import Final

GERMAN: Final[dict[str, str | dict[str, str]]] = {
    "place.imu": "Sensor",
    "unit.deg/s": "°/s",
    "unit.mdps": "m°/s",
    "unit.m/s^2": "m/s²",
    "unit.uT": "µT",
    "unit.us": "µs",
    "mapping.text_and_signal": "Die Zuordnung nimmt {columns:and} für Zahlen eines Signals und für Text; wählen Sie für"
    " eines davon eine andere Spalte.",
    "guess.signal": "{quantity:quantity} in {unit:unit} ({columns})",
    "guess.signal_of_rows": "{quantity:quantity} in {unit:unit} ({columns}, in Zeilen mit {rows})",
    "guess.signal_without_unit": "{quantity:quantity} in unbekannter Einheit ({columns})",
    "guess.sensor": "{where:place}: {signals:and}.",
    "guess.sensor_unread": "{where:place}: {signals:and}; die Zeit steht in der Spalte {column}.",
    "guess.sensor_stamped": "{where:place}: {signals:and}; {rate_hz:number~4} Messwerte in der Sekunde nach der"
    " Spalte {column}.",
    "guess.sensor_stamped_in": "{where:place}: {signals:and}; {rate_hz:number~4} Messwerte in der Sekunde nach der"
    " Spalte {column}, in {unit:unit}.",
    "guess.sensor_of_day": "{where:place}: {signals:and}; {rate_hz:number~4} Messwerte in der Sekunde nach den"
    " Uhrzeiten der Spalte {column}.",
    "guess.sensor_counted": "{where:place}: {signals:and}; {rate_hz:number~4} Messwerte in der Sekunde, gezählt von der"
    " Spalte {column}.",
    "guess.sensor_of_rows": "{where:place}: {signals:and}; {rate_hz:number~4} Messwerte in der Sekunde, einer in jeder"
    " Zeile.",
    "guess.units_from_numbers": "{quantity:quantity}: Die Spalten von {count:number} Sensoren nennen keine Einheit;"
    " ihren Zahlen nach ist es {unit:unit}.",
    "guess.units_assumed": "{quantity:quantity}: Die Spalten von {count:number} Sensoren nennen keine Einheit, und auch"
    " ihre Zahlen verraten keine; angenommen wird {unit:unit}.",
    "guess.time_unit_assumed": "Die Spalte {column} nennt keine Einheit; ihren Schritten nach zählt sie in"
    " {unit:unit}.",
    "guess.rate_of_line": "Die Rate von {rate_hz:number~4} Messwerten in der Sekunde steht in einer Zeile über der"
    " Tabelle.",
    "guess.turned": "{where:place}: {quantity:quantity} mit dem anderen Vorzeichen, wie Sie es gewählt haben.",
    "guess.sign_assumed": "Ohne Magnetometer zeigen die Signale das Vorzeichen des Beschleunigungssensors nicht: In"
    " Ruhe zeigt er, so die Annahme, nach oben, wie bei den meisten Geräten.",
    "guess.hemisphere_north": "Aufgenommen wurde, so die Annahme, nördlich des Äquators, wo das Magnetfeld nach unten"
    " zeigt.",
    "guess.hemisphere_south": "Aufgenommen wurde, so die Annahme, südlich des Äquators, wo das Magnetfeld nach oben"
    " zeigt.",
    "guess.hemisphere_unknown": "Wo aufgenommen wurde, ist nicht bekannt: Das Magnetfeld zeigt einen verkehrten"
    " Beschleunigungssensor nicht.",
    "upload.broken_off": "Das Hochladen brach vor dem Ende ab; senden Sie noch einmal.",
    "upload.csv_needs_mapping": "Ein CSV-Upload braucht `csv`: welche Spalte was enthält, in welcher Einheit.",
    "upload.damaged_packets": {
        "one": "{count} beschädigtes Paket wurde abgewiesen.",
        "other": "{count} beschädigte Pakete wurden abgewiesen.",
    },
    "upload.declaration_first": "Senden Sie den Teil `declaration` (JSON) vor dem Teil `file`.",
    "upload.declaration_too_long": "Die Angaben sind zu lang.",
    "upload.fields": "Die Angaben sind falsch bei: {fields:and}.",
    "upload.recorded_at": "Der Zeitpunkt der Aufnahme braucht eine Zeitzone und muss zwischen 2000 und jetzt liegen,"
    " zum Beispiel 2026-11-09T08:00:00Z.",
    "upload.day_unknown": "Die Datei sagt nicht, wann aufgenommen wurde: Die Sitzung zählt für den Tag, an dem sie"
    " hochgeladen wurde.",
    "upload.gone": "Die hochgeladene Datei gibt es nicht mehr; laden Sie sie noch einmal hoch.",
    "upload.header_too_long": "Ein Kopf eines Teils ist zu lang.",
    "upload.implausible": "Die Messwerte können nicht stimmen. {findings} {remedy}",
    "upload.correct_or_accept": "Berichtigen Sie die Angaben, und laden Sie die Datei noch einmal hoch, oder geben Sie"
    " `accept_implausible` an, um sie auszuwerten, wie sie ist.",
    "process.correct_or_force": "Sagen Sie, wo aufgenommen wurde (--hemisphere), oder geben Sie die Datei richtig an"
    ' (--mapping, darin dreht "sign": -1 alle Achsen eines Signals), oder werten Sie sie mit --force aus, wie sie ist.',
    "upload.malformed": "Der Inhalt ist kein wohlgeformtes multipart/form-data.",
    "upload.multipart": "Senden Sie multipart/form-data mit den Teilen `declaration` und `file`.",
    "upload.no_file": "Der Teil `file` fehlt.",
    "upload.parts": "Senden Sie genau die Teile `declaration` und `file`, in dieser Reihenfolge.",
    "upload.pose": "Die Haltung in `calibration_pose_s` muss ein Anfang und ein späteres Ende sein, in Sekunden"
    " der Aufzeichnung.",
    "upload.same_signals": "Die Sensoren senden dasselbe Signal: {where:place}. Ein Sensor kommt unter mehreren"
    " Namen; was von ihnen gezeigt wird, ist die Bewegung von einem. Prüfen Sie, welcher Sensor wo war, und"
    " laden Sie die Aufzeichnung noch einmal hoch.",
    "upload.too_large": "Die Datei ist größer als die Grenze von {limit_bytes:mib}; teilen Sie die Aufzeichnung.",
    "viewer.command": "Senden Sie Befehle `player` oder `camera` als JSON; siehe die Schnittstelle.",
    "viewer.command_too_long": "Ein Befehl hat höchstens 2 kB JSON.",
    "viewer.distance": "{place:place}: {distance_m:cm}",
    "viewer.distance_about": "{place:place}: etwa {distance_m:cm}",
    "viewer.markers_live": "Marker werden nur in der Wiedergabe gezeigt.",
    "viewer.no_guard": "Die 3D-Ansicht kann mit dieser Version von viser nicht geschützt werden; installieren"
    " Sie viser 1.1.",
    "viewer.no_picture": "Im Moment kein Livebild",
    "viewer.no_signal": "{place:place}: kein Signal",
    "viewer.not_found": "Diese 3D-Ansicht gibt es nicht mehr; öffnen Sie die Sitzung noch einmal.",
    "viewer.not_ready": "Die 3D-Ansicht ist nicht bereit; versuchen Sie es erneut.",
    "viewer.protocol": "Die Seite und die 3D-Ansicht haben verschiedene Versionen ({version}); laden Sie die"
    " Seite neu.",
    "viewer.sensor": "{place:place}",
    "viewer.session_ended": "Diese Sitzung ist beendet; öffnen Sie stattdessen eine Wiedergabe.",
    "viewer.silent": "Keine Daten von den Sensoren",
    "viewer.source": "{place:place}: Quelle",
    "viewer.version": "Die 3D-Ansicht kennt die Seite dieser Version von viser nicht; installieren Sie viser 1.1.",
}
