"""German sentences of the wire, and of files that no reader takes."""

from typing import Final

GERMAN: Final[dict[str, str | dict[str, str]]] = {
    "zip.damaged": "Das zip ist nicht lesbar: abgeschnitten, beschädigt oder ungewöhnlich gepackt. Packen Sie seine"
    " Tabellen neu.",
    "zip.locked": "Das zip hat ein Passwort. Packen Sie seine Tabellen ohne eines.",
    "zip.many": "Das zip enthält {count:number} Dateien; höchstens {most:number} werden gelesen. Packen Sie nur die"
    " Tabellen einer Aufzeichnung.",
    "zip.nested": "Das zip enthält ein weiteres zip oder Ordner in Ordnern. Packen Sie nur die Tabellen einer"
    " Aufzeichnung, in einen Ordner.",
    "zip.no_table": "Das zip enthält keine Tabelle mit Messwerten eines Sensors ({names:and}). Packen Sie Tabellen"
    " einer Aufzeichnung als CSV; eine Aufzeichnung in einer Datei anderer Art wird ohne das zip gewählt.",
    "zip.no_gravity": "{names:and}: Beschleunigung ohne Schwerkraft, und die Schwerkraft in einer eigenen Tabelle."
    " Zeichnen oder exportieren Sie die Beschleunigung mit Schwerkraft (in Sensor Logger: Total Acceleration).",
    "zip.clocks_differ": "Die Tabellen {names:and} zählen ihre Zeit in verschiedenen Einheiten; exportieren Sie sie"
    " gleich.",
    "zip.of_table": "{name}: {said}",
    "zip.joined": "{names:and} sind nach ihren Zeiten verbunden: Gleiche Zeit gilt als derselbe Augenblick.",
    "zip.joined_from_start": "{names:and} zählen jeweils ab ihrer ersten Zeile: Sie gelten als gleichzeitig begonnen."
    " Wenn das nicht stimmt, sind Winkel zwischen ihren Sensoren falsch.",
    "zip.joined_by_rows": "{names:and} haben keine Zeit: Ihre ersten Zeilen gelten als derselbe Augenblick.",
    "zip.pauses": {
        "one": "Die Aufzeichnung war einmal unterbrochen; die Pause steht wieder in ihrer Zeit.",
        "other": "Die Aufzeichnung war {count:number}\u2011mal unterbrochen; die Pausen stehen wieder in ihrer Zeit.",
    },
    "file.foreign": "{kind:foreign}",
    "foreign.workbook": "Das ist eine Arbeitsmappe eines Tabellenprogramms (Excel). Speichern Sie das Blatt mit den"
    " Messwerten als CSV, und wählen Sie diese Datei.",
    "foreign.document": "Das ist ein Dokument (PDF, Word), keine Aufzeichnung. Exportieren Sie die Messwerte als CSV"
    " aus dem Programm, das sie aufgezeichnet hat.",
    "foreign.picture": "Das ist ein Bild, keine Aufzeichnung. Wählen Sie die Datei mit den Messwerten der Sensoren.",
    "foreign.video": "Das ist ein Video oder ein Ton, keine Aufzeichnung von Sensoren. Wählen Sie die Datei mit den"
    " Messwerten der Sensoren.",
    "foreign.packed": "Diese Datei ist anders gepackt als mit zip. Entpacken Sie sie, und wählen Sie die"
    " Aufzeichnung darin, oder ein zip ihrer Tabellen.",
    "foreign.database": "Das ist eine Datenbank, wie Apps und Logger sie für sich selbst haben. Exportieren Sie die"
    " Aufzeichnung dort als CSV, und wählen Sie diese Datei.",
    "foreign.data_frame": "Das ist eine Datei eines Programms für Daten (Parquet, Arrow, NumPy, pickle). Speichern"
    " Sie ihre Tabelle als CSV, und wählen Sie diese Datei.",
    "foreign.xdf": "Das ist ein XDF von Lab Streaming Layer. Speichern Sie den Strom jedes Sensors mit seinen"
    " Zeitstempeln als CSV, und wählen Sie ein zip dieser Tabellen.",
    "foreign.c3d": "Das ist ein C3D eines Kamerasystems. Seine Marker werden zu einer Sitzung hinzugefügt, die es"
    " schon gibt; Messwerte von Sensoren in seinen analogen Kanälen sind als CSV zu exportieren.",
    "foreign.mtb": "Das ist eine Aufzeichnung von Xsens-Sensoren in der eigenen Form des Herstellers. Exportieren"
    " Sie sie im MT Manager als Text, mit Beschleunigung, Drehrate, Magnetfeld und Paketzähler, und wählen Sie"
    " diese Datei.",
    "foreign.activity": "Das ist eine Aufzeichnung eines Aktivitätsmessers. Eine mit Gyroskop (AX6) wird gelesen,"
    " wenn sie als CSV exportiert ist; ein Beschleunigungssensor allein ergibt keine Winkel.",
    "foreign.ximu3": "Das ist eine Aufzeichnung von x-IMU3-Geräten in der eigenen Form des Herstellers. Wandeln Sie"
    " sie in x-IMU3 GUI in CSV um, und wählen Sie ein zip von Inertial.csv und Magnetometer.csv.",
    "foreign.mvnx": "Das ist ein MVNX von MVN Analyze, mit Orientierungen von Segmenten. Gebraucht wird, was jeder"
    " Sensor gemessen hat, Drehrate und Beschleunigung, als CSV.",
    "foreign.web_page": "Das ist eine Webseite, keine Aufzeichnung: Vielleicht wurde die Seite vor dem Herunterladen"
    " gespeichert. Laden Sie die Aufzeichnung selbst herunter.",
    "foreign.xml": "Das ist eine XML-Datei; solche werden nicht gelesen. Exportieren Sie die Messwerte als CSV, und"
    " wählen Sie diese Datei.",
    "foreign.json": "Das ist eine JSON-Datei; solche werden nicht gelesen. Exportieren Sie die Messwerte als CSV,"
    " und wählen Sie diese Datei; Apps für Telefone fragen beim Export nach dem Format.",
    "foreign.opensim": "Das ist eine Datei von OpenSim, mit Orientierungen oder Ergebnissen. Wählen Sie die"
    " Aufzeichnung der Sensoren, aus der sie entstanden ist.",
    "file.hdf5_unknown": "Das ist ein HDF5 mit {names:and}, von keiner Art, die gelesen wird. Exportieren Sie die"
    " Messwerte als CSV, und wählen Sie diese Datei.",
    "hello.too_many": "Zu viele Tickets von dieser Adresse waren ungültig; versuchen Sie es in {seconds:s} erneut.",
    "hello.first": "Die erste Nachricht muss ein JSON-Hello sein.",
    "hello.no_sensor": "Das Hello nennt keinen Sensor; führen Sie die Stellen in der Reihenfolge der Pakete auf.",
    "hello.not_understood": "Das Hello ist nicht gültig: {faults}",
    "hello.placement_twice": "Eine Stelle ist zweimal genannt; jeder Sensor hat seine eigene.",
    "hello.placements_unknown": "Unbekannte Stellen: {unknown:and}; verwenden Sie {known:or}.",
    "hello.protocol_version": "Dieser Dienst spricht Protokollversion {ours}, das Hello {theirs}; aktualisieren Sie"
    " das Gateway.",
    "hello.rate": "Eine Rate von {rate_hz:number~4} Hz ist nicht möglich; senden Sie 10 bis 1000 Hz.",
    "hello.scale": "Der Wert von {field} ist {value}; er muss über 0 und höchstens {limit} in SI-Einheiten sein.",
    "hello.serials": "Das Hello nennt {sensors} Sensoren und {serials} verschiedene Seriennummern; senden Sie eine"
    " je Sensor, oder keine.",
    "hello.timeout": "Senden Sie innerhalb von {seconds:s} nach dem Verbinden ein Hello.",
}
