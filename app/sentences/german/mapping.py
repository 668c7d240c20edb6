"""German sentences of mappings, markers, measures and movements."""

from typing import Final

GERMAN: Final[dict[str, str | dict[str, str]]] = {
    "mapping.magnetometers": "Das Magnetometer ist hier nicht zugeordnet: {places:place}; ordnen Sie es für alle"
    " Sensoren zu oder für keinen.",
    "mapping.needed": "{where:place}: nicht zugeordnet ist {quantity:quantity}; Gyroskop und"
    " Beschleunigungssensor sind beide nötig.",
    "mapping.no_sensor": "Die Zuordnung nennt keinen Sensor; ordnen Sie Gyroskop und Beschleunigungssensor von"
    " mindestens einem zu.",
    "mapping.no_time": "Die Zuordnung nennt weder eine Zeitspalte noch eine Rate; geben Sie eines davon an.",
    "mapping.rate": "Eine Rate von {rate_hz:number~4} Hz ist nicht möglich; verwenden Sie {lowest_hz:number} bis"
    " {highest_hz:hz}.",
    "mapping.twice": "{where:place}: zweimal zugeordnet ist {quantity:quantity}, zu den Spalten {first:and} und"
    " noch einmal zu {second:and}; behalten Sie eine.",
    "mapping.unit": "Für {quantity:quantity} (Spalten {columns:and}) ist die Einheit {unit} nicht möglich;"
    " verwenden Sie {units:or}.",
    "marker_file.check_unit": "Prüfen Sie die Einheit.",
    "marker_file.columns": "Es wurde kein Marker gefunden: Jeder braucht drei Spalten, NAME_x, NAME_y und"
    " NAME_z. Die Datei hat: {present}.",
    "marker_file.far": "Ein Marker ist {far_m:m.0} vom Ursprung entfernt, was nicht möglich ist. {advice}",
    "marker_file.never_seen": "In dieser Datei ist zu keiner Zeit ein Marker sichtbar.",
    "marker_file.no_marker": "Die Datei hat keinen Marker {marker}; sie hat {names:and}.",
    "marker_file.no_time": "Die Datei hat keine Spalte time_s; fügen Sie sie hinzu, oder geben Sie die Rate der"
    " Kameras an.",
    "marker_file.rate": "Die Bilder kommen mit {rate_hz:hz~3}, was nicht möglich ist; prüfen Sie, ob time_s in"
    " Sekunden ist.",
    "marker_file.unit": "Die Werte sehen nach mm oder cm aus: Geben Sie diese Einheit an.",
    "marker_fusion.cluster": "Eine Gruppe braucht mindestens drei verschiedene Marker.",
    "marker_fusion.inches": "Beim Schreiben der Datei scheinen Zoll und Zentimeter vertauscht worden zu sein.",
    "marker_fusion.refused": "{reason} Prüfen Sie das Segment, und welche Achse nach oben zeigt.",
    "marker_fusion.unit": "Die Zahlen der Datei sehen nach {unit} aus, nicht nach {declared}: Wählen Sie diese"
    " Einheit.",
    "marker_fusion.up": "In den Achsen der Datei zeigt {axis} nach oben.",
    "markers.bridged": {
        "one": "{lost_s:s.2} der Messwerte des Sensors gingen an einem Stück unterwegs verloren und wurden"
        " interpoliert. Sie zählen mit erhöhtem Rauschen.",
        "other": "{lost_s:s.2} der Messwerte des Sensors gingen in {count:number} Stücken unterwegs verloren"
        " und wurden interpoliert. Sie zählen mit erhöhtem Rauschen.",
    },
    "markers.contradict": "Die Marker widersprechen diesem Sensor. {wrong:lines}",
    "markers.far": "Der Marker wäre {distance_m:m.2} von seinem Sensor entfernt, mehr als ein Körpersegment"
    " zulässt. Wählen Sie den Sensor, der den Marker trug, und prüfen Sie, ob Datei und Sitzung von"
    " derselben Aufzeichnung sind; oder messen Sie den Abstand und geben Sie ihn ein.",
    "markers.few_frames": "Neben dem Sensor war der Marker in weniger als zehn Bildern zu sehen.",
    "markers.gone": "Die hochgeladenen Marker gibt es nicht mehr; laden Sie sie noch einmal hoch.",
    "markers.limit": "Diese Sitzung enthält so viele Markerdateien, wie sie darf ({limit_bytes:mib}).",
    "markers.little_overlap": "Marker und Sensor haben zu wenig Zeit oder Bewegung gemeinsam. Zeichnen Sie ein"
    " paar Sekunden lebhafter Bewegung auf.",
    "markers.mirrored": "Sie sind ein Spiegelbild dessen, was der Sensor gemessen hat: Die Spalten {one} und z"
    " sind vertauscht, oder eine hat das falsche Vorzeichen. Schreiben Sie x, y und z rechtshändig.",
    "markers.mirrored_columns": "Sie sind ein Spiegelbild dessen, was der Sensor gemessen hat: Zwei Spalten sind"
    " vertauscht, oder eine hat das falsche Vorzeichen. Schreiben Sie x, y und z rechtshändig.",
    "markers.moved_little": "Der Marker hat sich zu wenig bewegt, um die Richtung des Sensors zu messen. Bewegen"
    " Sie ihn einige Sekunden zügig hin und her.",
    "markers.no_correlation": "Die Marker passen nicht zu diesem Sensor: beste Korrelation"
    " {correlation:number.2}, anderswo {rival:number.2}. Wählen Sie den Sensor, der den Marker trug, oder"
    " zeichnen Sie eine unregelmäßige Bewegung auf.",
    "markers.no_such_sensor": "Diese Sitzung hat hier keinen Sensor: {place:place}; sie hat: {sent:place}.",
    "markers.none": "Diese Sitzung hat noch keine zusammengeführten Marker.",
    "markers.none_inside": "Kein Marker fällt in die Aufzeichnung des Sensors.",
    "markers.not_closed": "Marker können nur zu einer Sitzung hinzugefügt werden, die beendet und ausgewertet"
    " ist.",
    "markers.rate_needs_three": "Eine Drehrate braucht drei Marker an einem Körper. Gleichen Sie mit einem"
    " Marker über seine Beschleunigung ab.",
    "markers.residual": "Zwischen Markern und Sensor bleiben {residual_m:mm}, was kein Sensor erklärt. Wählen"
    " Sie den Sensor, der den Marker trug, und prüfen Sie, ob Datei und Sitzung von derselben Aufzeichnung"
    " sind.",
    "markers.scale": "Ihre Längen sind das {scale:number~3}\u2011fache (± {sigma:number~1}) der vom Sensor"
    " gemessenen. Prüfen Sie die Einheit der Datei.",
    "markers.seen_short": "Neben dem Sensor war der Marker weniger als {least_s:s} zu sehen.",
    "markers.short": "Die Aufzeichnung des Sensors ist für seine Marker zu kurz.",
    "markers.short_stretch": "Weniger als {least_s:s} Messwerte am Stück.",
    "markers.shut_out": "{share:percent} der Bilder widersprechen diesem Sensor; höchstens {most:percent} dürfen"
    " Geisterbilder sein. Wählen Sie den Sensor, der den Marker trug, und prüfen Sie, ob Datei und Sitzung"
    " von derselben Aufzeichnung sind.",
    "markers.six_frames": "Für den Anfang sind sechs Bilder des Markers am Stück nötig.",
    "markers.stretch": "{reason} (Von {start_s:s.1} bis {stop_s:s.1}.)",
    "markers.too_long": "Fragen Sie höchstens {longest_s:s} der Aufzeichnung an.",
    "markers.uneven": "Marker und Sensor brauchen je mindestens zehn Messwerte zu steigenden Zeiten.",
    "markers.unexplained": "Die Marker passen nicht zu diesem Sensor: Er erklärt {explained:percent} ihrer"
    " Beschleunigung. Wählen Sie den Sensor, der den Marker trug.",
    "markers.up": "Ihre Achse {up} zeigt nach oben, nicht z: Wählen Sie {up} als Achse, die nach oben zeigt.",
    "markers.up_mirrored": "Ihre Achse {up} zeigt nach oben, nicht z.",
    "markers.walk": "Die Marker nach Lücken passen nur, wenn sich die Nullpunkte des Sensors"
    " {times:number~3}\u2011mal so schnell ändern dürfen.",
    "mass_centre.sensors": "Der Körperschwerpunkt braucht Sensoren an beiden Oberschenkeln und an Brust oder"
    " Becken.",
    "mat.unreadable": "Die Datei ist nicht als .mat-Datei lesbar; speichern Sie sie als Version 5 oder 7.",
    "mat.version": "Diese .mat-Datei hat Version 7.3; speichern Sie sie als Version 5 oder 7.",
    "measure.joint_still": "Nicht bestimmt: Schulter oder Ellbogen bewegte sich auf dem Hinweg weniger als"
    " {least_rad:deg}.",
    "measure.no_peak": "Nicht bestimmt: Die Geschwindigkeit hat auf dem Hinweg keinen Gipfel.",
    "measure.no_stroke": "Nicht bestimmt: Die Bewegung hat keinen klaren Hinweg.",
    "measure.straight_path": "Der Weg ist gerade: Wie weit er um sich selbst gedreht ist, lässt sich nicht sagen.",
    "measure.stroke_short": "Nicht bestimmt: Der Hinweg dauerte weniger als {least_s:s.1}.",
    "measure.unlike_angle": "Nicht bestimmt: Die Wiederholungen weichen um {rms_rad:deg.1} von ihrem Mittel ab,"
    " zu viel für eine Bewegung von {extent_rad:deg.1}.",
    "measure.unlike_length": "Nicht bestimmt: Die Wiederholungen weichen um {rms_m:cm} von ihrem Mittel ab, zu"
    " viel für eine Bewegung von {extent_m:cm}.",
    "measure.way_short": "Nicht bestimmt: Die Hand bewegte sich weniger als {share:percent} der Reichweite.",
    "movement.elbow_flexion": "Ellbogen beugen",
    "movement.pronation": "Handfläche nach oben und unten drehen",
    "movement.raise_forward": "Arm nach vorn heben",
    "movement.raise_sideways": "Arm zur Seite heben",
}
