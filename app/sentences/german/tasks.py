"""German sentences of tasks and limits, and titles of estimators and file formats."""

from typing import Final

GERMAN: Final[dict[str, str | dict[str, str]]] = {
    "job.analysis_failed": "Die Auswertung ist fehlgeschlagen. {reason}",
    "job.given_up": "Die Aufgabe wurde mehrmals unterbrochen und wird nicht noch einmal versucht; die"
    " aufgezeichneten Daten sind gespeichert.",
    "job.internal": "Ein innerer Fehler hat diese Aufgabe angehalten und wurde festgehalten. Die aufgezeichneten"
    " Daten sind gespeichert.",
    "job.interrupted": "Unterbrochen; die Aufgabe beginnt von vorn.",
    "job.memory": "Das braucht mehr Speicher als die {limit_bytes:gib.1}, die eine Aufgabe nehmen darf. Teilen"
    " Sie die Aufzeichnung, und laden Sie die Teile hoch.",
    "job.not_found": "Diese Aufgabe wurde nicht gefunden.",
    "job.session_deleted": "Die Sitzung dieser Aufgabe wurde gelöscht.",
    "job.unknown_kind": "Dieser Dienst kann Aufgaben der Art {kind} nicht ausführen.",
    "level.erase": "Löschen",
    "level.manage": "Verwalten",
    "level.read": "Lesen",
    "level.record": "Aufzeichnen",
    "level.status": "Sehen des Zustands",
    "level.treat": "Behandeln",
    "limit.exports": "Warten Sie, bis einer fertig ist, und fragen Sie dann noch einmal.",
    "limit.reached": "{what:limited} ({scope:limit_scope}): höchstens {most} auf einmal. {advice}",
    "limit.sockets": "Schließen Sie eine, und öffnen Sie diese dann noch einmal.",
    "limit.streams": "Beenden Sie eine Sitzung, und verbinden Sie dann noch einmal.",
    "limit.uploads": "Warten Sie, bis eines angekommen ist, und senden Sie dieses dann noch einmal.",
    "limit.views": "Schließen Sie eine, oder versuchen Sie es in einer Minute noch einmal.",
    "limit_scope.account": "je Konto",
    "limit_scope.clinic": "in Ihrer Praxis",
    "limit_scope.service": "in diesem Dienst",
    "limited.exports": "Exporte in Arbeit",
    "limited.sockets": "Offene Live-Ansichten",
    "limited.streams": "Übertragende Sensorboxen",
    "limited.uploads": "Laufendes Hochladen",
    "limited.views": "Offene 3D-Ansichten",
    "estimator_title.telemotion": "Telemotion",
    "estimator_text.telemotion": "Lernt beim Tragen auch die Fehler jedes Sensors und nahe Magnete; die"
    " genaueste direkte Schätzung.",
    "estimator_title.vqf": "VQF",
    "estimator_text.vqf": "Lernt die Drift des Sensors in Ruhe und Bewegung und übergeht vorübergehende"
    " magnetische Störungen; weit verbreitet und gut erprobt.",
    "estimator_title.marzouk_quaternion_ekf": "Quaternionen-Kalman-Filter",
    "estimator_text.marzouk_quaternion_ekf": "Das veröffentlichte Filter zur Armüberwachung mit"
    " berichtigten Gleichungen; zum Vergleich mit früheren Arbeiten.",
    "estimator_title.marzouk_error_state_ekf": "Fehlerzustands-Kalman-Filter",
    "estimator_text.marzouk_error_state_ekf": "Ein Kalman-Filter ohne singuläre Stellungen, dessen Neigung"
    " nie einem Magneten folgt; gibt seine Unsicherheit an.",
    "estimator_title.marzouk_euler_ekf": "Euler-Winkel-Kalman-Filter",
    "estimator_text.marzouk_euler_ekf": "Das erste veröffentlichte Filter zur Armüberwachung, das sich"
    " verliert, wenn der Sensor gerade nach oben oder unten zeigt; zum Vergleich mit früheren Arbeiten.",
    "estimator_title.luinge_inclination": "Neigungs-Kalman-Filter",
    "estimator_text.luinge_inclination": "Veröffentlichtes Filter, das Magnetismus übergeht: Wie weit sich"
    " jeder Sensor neigt, stimmt; wohin er zeigt, driftet.",
    "estimator_title.roetenberg_disturbance": "Kalman-Filter für magnetische Störungen",
    "estimator_text.roetenberg_disturbance": "Veröffentlichtes Filter, das ermittelt, wie nahes Eisen das"
    " Magnetfeld verbiegt, und daneben die Richtung hält.",
    "estimator_title.telemotion_smoother": "Telemotion, nachträglich",
    "estimator_text.telemotion_smoother": "Betrachtet die ganze Sitzung vorwärts und rückwärts, sobald sie"
    " aufgezeichnet ist; am genauesten.",
    "format_title.zipped": "Mehrere Tabellen einer Aufzeichnung (zip)",
    "format_text.zipped": "Tabellen eines Telefons, oder eine für jeden Sensor, mit gemeinsamer Uhr",
    "format_title.apdm": "APDM-Sensoren (CSV)",
    "format_text.apdm": "Sensoren, nach ihrem Trageort benannt, wie das Programm von APDM sie schreibt",
    "format_title.broad": "BROAD-Versuch (.mat, .hdf5)",
    "format_text.broad": "Ein Sensor mit seiner optischen Referenz",
    "format_title.csv": "Tabelle (CSV)",
    "format_text.csv": "Beliebige Sensoren: Sie geben an, welche Spalte was ist, und in welcher Einheit",
    "format_title.gait_tracking": "Gang mit einem Fußsensor (x-io, CSV)",
    "format_text.gait_tracking": "Ein Sensor an einem Fuß, wie der Gait-Tracking-Satz ihn schreibt",
    "format_title.gaitmap": "Gang mit beiden Füßen (gaitmap, CSV)",
    "format_text.gaitmap": "Sensoren an beiden Füßen, wie die gaitmap-Bibliothek sie schreibt",
    "format_title.instrumented_shoe": "Gang auf Messschuhen (CSV)",
    "format_text.instrumented_shoe": "Inertialsensoren und Kraftmesszellen unter Ferse und Vorfuß",
    "format_title.packet_log": "Paketprotokoll einer Sensorbox",
    "format_text.packet_log": "Wie aus einer Sitzung heruntergeladen oder von einer Sensorbox gespeichert"
    " (.tmlog)",
    "format_title.pyshoe": "Gang mit einem Fußsensor (PyShoe, .mat)",
    "format_text.pyshoe": "Ein Sensor am rechten Fuß",
    "format_title.qmt_mat": "Ganzkörperaufzeichnung (.mat)",
    "format_text.qmt_mat": "MATLAB-Datei mit 16 benannten Sensoren; Arme und Rumpf werden verwendet",
    "scaled.fenced": "Ein anderer Rechner führt diese Sitzungen inzwischen; von diesem wird nichts mehr gespeichert.",
    "scaled.moving": "Die Sitzung wechselt auf einen anderen Rechner; sie geht gleich weiter.",
    "scaled.mqtt_lost": "Unterwegs gingen Nachrichten verloren; neu verbinden und senden, was fehlt.",
    "scaled.no_broker": "NATS ist nicht erreichbar: {reason}. Prüfen Sie TELEMOTION_NATS_URL und ob es läuft.",
    "scaled.no_broker_right": "NATS lässt diesen Prozess nicht ein: {reason}. Prüfen Sie Namen und Passwort in"
    " TELEMOTION_NATS_URL oder die Datei, die TELEMOTION_NATS_CREDENTIALS nennt.",
    "scaled.no_credentials": "{path} ist keine Datei mit Zugangsdaten für NATS: {reason}. Erwartet wird eine"
    " .creds-Datei oder der geheime NKEY eines Benutzers (SU...).",
    "scaled.no_nats_password": "TELEMOTION_NATS_URL und jede Adresse in TELEMOTION_NATS_EDGE_URL müssen Namen und"
    " Passwort nennen, wie in nats://edge-1:PASSWORT@rechner:4222.",
    "scaled.nats_user_name": "Der Name eines NATS-Benutzers darf Buchstaben, Ziffern, - und _ haben, höchstens 40.",
    "scaled.one_nats_user": "Ein Zugangsrechner (edge) darf nicht Namen oder Passwort der Arbeitsrechner (worker)"
    " haben: Nennen Sie eigene Benutzer in TELEMOTION_NATS_EDGE_URL.",
    "scaled.unread_packets": "Diese Sicherung hat Pakete, die noch kein Arbeitsrechner (worker) gespeichert"
    " hatte; stellen Sie sie zuerst auf PostgreSQL und NATS wieder her.",
    "scaled.other_partitions": "Diese Sicherung hat {count:number} Teile; setzen Sie TELEMOTION_PARTITIONS auf diese"
    " Zahl.",
    "scaled.streams_not_empty": "Die Ströme von NATS sind nicht leer; nennen Sie einen NATS-Server ohne Sitzungen.",
    "scaled.no_gateways_here": "Gateways verbinden sich mit einem Zugangsrechner (edge), nicht mit einem Arbeitsrechner"
    " (worker).",
}
