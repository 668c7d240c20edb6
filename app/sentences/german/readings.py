"""German sentences of implausible readings."""

from typing import Final

GERMAN: Final[dict[str, str | dict[str, str]]] = {
    "readings.accelerometer_against_others": "{where:place}: Die Achsen des Beschleunigungssensors passen nicht"
    " zu den anderen Sensoren. Prüfen Sie die angegebenen Achsen: {mapping:and}.",
    "readings.accelerometer_clipped": "{where:place}: Der Beschleunigungssensor endet bei {level_mps2:mps2}."
    " Wählen Sie einen größeren Bereich.",
    "readings.accelerometer_dead": "{where:place}: Der Beschleunigungssensor ändert sich nie. Tauschen Sie den"
    " Sensor aus, oder prüfen Sie seine Verdrahtung.",
    "readings.accelerometer_uncalibrated": "{where:place}: Der Beschleunigungssensor hat einen Nullpunkt- oder"
    " Skalenfehler, der die Messwerte um etwa {angle_rad:deg.1} neigt. Er wurde nie kalibriert, oder seine"
    " Kalibrierung wurde nicht angewandt. Kalibrieren Sie ihn in sechs Lagen.",
    "readings.accelerometer_corrected": "{where:place}: Nullpunkt- und Skalenfehler des Beschleunigungssensors wurden"
    " aus der Bewegung bestimmt und abgezogen; wie aufgenommen wäre der Sensor um etwa {angle_rad:deg.1} geneigt."
    " Was unbekannt bleibt, {sigma_rad:deg.1}, ist in der Unsicherheit des Ergebnisses enthalten. Kalibrieren Sie ihn"
    " in sechs Lagen, um genauer zu messen.",
    "readings.accelerometer_unit": "{where:place}: Der Beschleunigungssensor zeigt in Ruhe {value:number~4},"
    " erwartet sind 9,81 m/s². {remedy}",
    "readings.axes_in_doubt": "{where:place}: Gyroskop, Beschleunigungssensor und Magnetometer passen nicht ganz"
    " zueinander. So sieht es bei Eisen oder einem Magneten in der Nähe aus, aber auch bei falsch angegebenen Achsen."
    " Gehen Sie von Eisen weg, und drehen Sie den Sensor um jede seiner Achsen; kommt dieser Hinweis wieder, lassen Sie"
    " den Sensor prüfen.",
    "readings.axes_in_doubt_six": "{where:place}: Gyroskop und Beschleunigungssensor passen nicht ganz zueinander."
    " Drehen Sie den Sensor um jede seiner Achsen; kommt dieser Hinweis wieder, prüfen Sie die angegebenen Achsen, und"
    " lassen Sie den Sensor prüfen.",
    "readings.axes_unclear": "{where:place}: Die Achsen seiner Messgrößen passen nicht zueinander, und diese Bewegung"
    " zeigt nicht, welche vertauscht sind. Drehen Sie den Sensor um jede seiner Achsen, und prüfen Sie die angegebenen"
    " Achsen.",
    "readings.axes_apart": "{where:place}: Gyroskop und Beschleunigungssensor haben nicht dieselben Achsen."
    " Prüfen Sie die angegebenen Achsen: {mapping:and}.",
    "readings.field_axes_apart": "{where:place}: Gyroskop und Magnetometer haben nicht dieselben Achsen."
    " Prüfen Sie die angegebenen Achsen: {mapping:and}.",
    "readings.field_down": "{where:place}: Das Magnetfeld zeigt um {angle_rad:deg} nach unten. Das stimmt, wo"
    " nördlich des Äquators aufgenommen wurde: Geben Sie das an. Sonst liefert der Beschleunigungssensor Schwerkraft"
    " statt spezifischer Kraft, wie Telefone und Geräte mit Nord-Ost-unten-Achsen, oder das Magnetometer ist"
    " umgekehrt: Geben Sie seinen Spalten das andere Vorzeichen.",
    "readings.field_in_gauss": "Das sieht nach Gauß aus: durch 10 000 teilen.",
    "readings.field_in_microtesla": "Das sieht nach Mikrotesla aus: durch 1 000 000 teilen.",
    "readings.field_in_milligauss": "Das sieht nach Milligauß aus: durch 10 000 000 teilen.",
    "readings.field_in_nanotesla": "Das sieht nach Nanotesla aus: durch 1 000 000 000 teilen.",
    "readings.field_normalised": "Das sieht nach einem normierten Feld aus: Senden Sie die Rohwerte.",
    "readings.field_off": "{where:place}: Das Magnetometer zeigt {field_t:ut~3}, erwartet sind 25 bis 65 µT."
    " Gehen Sie weg von Eisen und Magneten, und kalibrieren Sie es; hilft das nicht, prüfen Sie die Einheit.",
    "readings.field_up": "{where:place}: Das Magnetfeld zeigt um {angle_rad:deg} nach oben. Das stimmt, wo"
    " südlich des Äquators aufgenommen wurde: Geben Sie das an. Sonst liefert der Beschleunigungssensor Schwerkraft"
    " statt spezifischer Kraft, wie Telefone und Geräte mit Nord-Ost-unten-Achsen, oder das Magnetometer ist"
    " umgekehrt: Geben Sie seinen Spalten das andere Vorzeichen.",
    "readings.field_varies": "{where:place}: Das Magnetfeld schwankt um {share:percent}. Gehen Sie weg von Eisen"
    " und Magneten, oder kalibrieren Sie das Magnetometer.",
    "readings.force_in_counts": "Das sieht nach rohen Zählwerten aus: Skalieren Sie sie nach dem Datenblatt.",
    "readings.force_in_feet": "Das sieht nach ft/s² aus: mit 0,3048 malnehmen.",
    "readings.force_in_g": "Das sieht nach g aus: mit 9,80665 malnehmen.",
    "readings.force_in_milli_g": "Das sieht nach mg oder cm/s² aus: mit 0,00980665 oder 0,01 malnehmen.",
    "readings.force_off": "Seine Skala oder sein Nullpunkt ist falsch, oder Bereich oder Einheit sind andere."
    " Kalibrieren Sie ihn in sechs Lagen; zeigt er danach dasselbe, prüfen Sie Bereich und Einheit.",
    "readings.force_unknown": "Prüfen Sie Einheit, Bereich und Kalibrierung.",
    "readings.force_without_gravity": "Das Gerät entfernt die Schwerkraft: Stellen Sie es auf rohe"
    " Beschleunigung um.",
    "readings.gyroscope_against_accelerometer": "{where:place}: Die Achsen des Gyroskops passen nicht zu denen"
    " des Beschleunigungssensors. Prüfen Sie die angegebenen Achsen: {mapping:and}.",
    "readings.gyroscope_against_magnetometer": "{where:place}: Die Achsen des Gyroskops passen nicht zu denen"
    " des Magnetometers. Prüfen Sie die angegebenen Achsen: {mapping:and}.",
    "readings.gyroscope_against_others": "{where:place}: Die Achsen des Gyroskops passen nicht zu den anderen"
    " Sensoren. Prüfen Sie die angegebenen Achsen: {mapping:and}.",
    "readings.gyroscope_clipped": "{where:place}: Das Gyroskop endet bei {level_radps:degps}, schnellere"
    " Bewegung geht also verloren. Wählen Sie einen größeren Bereich, oder bewegen Sie sich langsamer.",
    "readings.gyroscope_dead": {
        "one": "{where:place}: Eine Achse des Gyroskops ändert sich nie ({axes:and}). Tauschen Sie den Sensor"
        " aus, oder prüfen Sie seine Verdrahtung.",
        "other": "{where:place}: Achsen des Gyroskops ändern sich nie ({axes:and}). Tauschen Sie den Sensor"
        " aus, oder prüfen Sie seine Verdrahtung.",
    },
    "readings.gyroscope_in_degrees": "{where:place}: Das Gyroskop zeigt das 57-fache der Drehung des Sensors:"
    " Grad/s sind als rad/s angegeben. Durch 57,296 teilen oder Grad/s angeben.",
    "readings.gyroscope_restless": "{where:place}: Das Gyroskop zeigt {rate_radps:number~2} rad/s, während der"
    " Beschleunigungssensor stillsteht. Lag der Sensor still, können das Grad/s sein: Geben Sie sie so an; sonst"
    " bestimmen Sie den Gyroskop-Nullpunkt.",
    "readings.gyroscope_scale": "{where:place}: Das Gyroskop zeigt das {factor:number~3}\u2011fache der Drehung des"
    " Sensors, nach Schwerkraft und Feld beurteilt. Prüfen Sie Einheit und Skalenfaktor.",
    "readings.gyroscope_pace": "{where:place}: Nach Schwerkraft und Feld dreht sich der Sensor"
    " {factor:number~3}\u2011mal so weit, wie sein Gyroskop sagt. Entweder stimmt die Rate oder die Uhr nicht: Dann"
    " kommen die Messwerte mit {rate_hz:hz}, nicht mit {said_hz:hz}; geben Sie diese Rate an, oder berichtigen Sie die"
    " Zeiten. Oder die Einheit oder der Messbereich des Gyroskops stimmt nicht: Dann nehmen Sie seine Spalten mal"
    " {factor:number~3}. Welches von beiden, zeigen die Signale nicht.",
    "readings.gyroscope_silent": "{where:place}: Der Sensor dreht sich, aber sein Gyroskop zeigt nichts."
    " Tauschen Sie ihn aus.",
    "readings.gyroscope_too_calm": "{where:place}: Das Gyroskop zeigt höchstens {rate_radps:number~2} rad/s,"
    " obwohl der Sensor mit {force_mps2:mps2} geschüttelt wird. Prüfen Sie seine Einheit.",
    "readings.gyroscope_twice": "{where:place}: Das Gyroskop zeigt ein 57stel der Drehung des Sensors: rad/s"
    " wurden zweimal umgerechnet. Geben Sie rad/s an.",
    "readings.live_sensor_axes": "{where:place}: Die Achsen dieses Sensors passen nicht zueinander, so wie seine"
    " Sensorbox sie angibt ({mapping:and}). Nehmen Sie einen anderen Sensor, und sagen Sie es dem, der die"
    " Sensorbox eingerichtet hat.",
    "readings.live_sensor_amiss": "{where:place}: Gyroskop, Beschleunigungssensor und Magnetometer dieses Sensors"
    " passen nicht ganz zueinander. Gehen Sie von Eisen weg, und drehen Sie den Sensor um jede seiner Achsen;"
    " kommt dieser Hinweis wieder, nehmen Sie einen anderen Sensor, und lassen Sie diesen prüfen.",
    "readings.live_gyroscope_pace": "{where:place}: Nach Schwerkraft und Feld dreht sich dieser Sensor"
    " {factor:number~3}\u2011mal so weit, wie sein Gyroskop sagt: Seine Uhr stimmt nicht, oder der Messbereich, den"
    " seine Sensorbox angibt. Nehmen Sie einen anderen Sensor, und sagen Sie es dem, der die Sensorbox eingerichtet"
    " hat.",
    "readings.live_gyroscope_unit": "{where:place}: Das Gyroskop misst nicht in der Einheit, die seine Sensorbox"
    " angibt. Nehmen Sie einen anderen Sensor, und sagen Sie es dem, der die Sensorbox eingerichtet hat.",
    "readings.live_gyroscope_restless": "{where:place}: Das Gyroskop zeigt {rate_radps:number~2} rad/s, während"
    " der Beschleunigungssensor stillsteht. Legen Sie den Sensor hin, und bestimmen Sie seinen"
    " Gyroskop-Nullpunkt; kommt dieser Hinweis wieder, nehmen Sie einen anderen Sensor.",
    "readings.live_accelerometer_unit": "{where:place}: Der Beschleunigungssensor zeigt die Schwerkraft nicht in"
    " der Einheit, die seine Sensorbox angibt. Nehmen Sie einen anderen Sensor, und sagen Sie es dem, der die"
    " Sensorbox eingerichtet hat.",
    "readings.live_magnetometer_unit": "{where:place}: Das Magnetometer misst nicht in der Einheit, die seine"
    " Sensorbox angibt. Nehmen Sie einen anderen Sensor, und sagen Sie es dem, der die Sensorbox eingerichtet"
    " hat.",
    "readings.live_field_up": "{where:place}: Das Magnetfeld zeigt um {angle_rad:deg} nach oben. Das stimmt"
    " südlich des Äquators: Stellen Sie die Erdhalbkugel dieses Dienstes ein. Sonst gibt die Sensorbox"
    " Schwerkraft oder Feld mit dem anderen Vorzeichen: Nehmen Sie einen anderen Sensor, und sagen Sie es dem,"
    " der sie eingerichtet hat.",
    "readings.live_field_down": "{where:place}: Das Magnetfeld zeigt um {angle_rad:deg} nach unten. Das stimmt"
    " nördlich des Äquators: Stellen Sie die Erdhalbkugel dieses Dienstes ein. Sonst gibt die Sensorbox"
    " Schwerkraft oder Feld mit dem anderen Vorzeichen: Nehmen Sie einen anderen Sensor, und sagen Sie es dem,"
    " der sie eingerichtet hat.",
    "readings.magnetometer_against_gyroscope": "{where:place}: Die Achsen des Magnetometers passen nicht zu"
    " denen des Gyroskops. Prüfen Sie die angegebenen Achsen: {mapping:and}.",
    "readings.magnetometer_constant": "{where:place}: Das Magnetometer ändert sich nie. Geben Sie an, dass es"
    " keines gibt, oder schalten Sie es ein.",
    "readings.magnetometer_frozen": "{where:place}: Das Magnetometer wiederholte {lasts_s:s} lang einen Wert,"
    " während sich der Sensor drehte. Richtungen beruhen dort allein auf dem Gyroskop; prüfen Sie den Sensor"
    " und seine Verbindung.",
    "readings.magnetometer_unit": "{where:place}: Das Magnetometer zeigt {value:number~3}, erwartet sind"
    " 0,000025 bis 0,000065 T. {remedy}",
    "readings.magnetometer_zero": "{where:place}: Das Magnetometer zeigt immer null. Geben Sie an, dass es"
    " keines gibt, oder schalten Sie es ein.",
    "readings.more": {
        "one": "Ein weiterer Befund.",
        "other": "{count} weitere Befunde.",
    },
    "readings.no_data": "{where:place}: Es kommen kaum Messwerte an. Prüfen Sie, ob der Sensor eingeschaltet und"
    " in der Nähe ist.",
    "readings.unexplained": "{where:place}: Das Gyroskop passt nicht zu dem, was Schwerkraft und Magnetfeld im Sensor"
    " tun, und weder eine andere Einheit noch vertauschte Achsen erklären es. Prüfen Sie zuerst die Abtastrate und die"
    " Zeitstempel, dann, ob Messwerte mehrerer Sensoren vermischt sind, dann Eisen in der Nähe.",
}
