"""German sentences of shoes, sign-in, signals, positions, sources and states."""

from typing import Final

GERMAN: Final[dict[str, str | dict[str, str]]] = {
    "shoe.weight": "Das von den Schuhen gemessene Körpergewicht ist {weight_n:number} N; ein Mensch wiegt"
    " {least_n:number} bis {most_n:number} N. Prüfen Sie die Einheit (Newton), und ob z nach oben gegen den"
    " Fuß zeigt.",
    "shoes.cell_jammed": "Die Kraftmesszelle ({cell:load_cell}) ist nie ohne Last, obwohl der Schuh schwingt."
    " Tarieren Sie sie, und prüfen Sie, ob sie klemmt.",
    "shoes.cells_missing": "Kräfte brauchen Kraftmesszellen unter Ferse und Vorfuß beider Füße.",
    "shoes.clipped": "Die Kraftmesszelle endet bei {level_n:number} N: {where:place}. Was darüber liegt, fehlt;"
    " Kräfte, Momente und Gleichgewicht sind deshalb zu klein.",
    "shoes.exchanged": "Nach den Kräften stand der linke Fuß rechts vom rechten. Linker und rechter Schuh"
    " scheinen vertauscht zu sein.",
    "shoes.few_loads": "{loads:number} Belastungen sind zu wenig. Verwenden Sie mindestens {least:number}, in"
    " allen Richtungen.",
    "shoes.loads_alike": "Diese Belastungen trennen die Kanäle nicht. Drücken Sie entlang x, y und z, in beide"
    " Richtungen und außermittig.",
    "shoes.loads_apart": "Schuh {side:side}: Er zeigt {load_n:number} N, während er allein steht, der andere"
    " {other_n:number} N. Prüfen Sie seine Kraftmesszellen.",
    "shoes.never_loaded": "Die Schuhe wurden nie belastet. Prüfen Sie Kalibrierung und Einheiten (Newton).",
    "shoes.never_still": "In dieser Aufzeichnung steht niemand still, deshalb kann niemand gewogen werden.",
    "shoes.no_cell": "Der Sensor ({cell:load_cell}) hat in dieser Aufzeichnung keine Kraftmesszelle.",
    "shoes.no_cycle": "Ein Gangzyklus liegt zwischen zwei Bodenkontakten eines Fußes; es wurden weniger gefunden.",
    "shoes.no_stance": "Es wurde kein Stand gefunden: Der Fuß liegt nie flach. Prüfen Sie Tarierung und"
    " Schwellen.",
    "shoes.no_weight": "Schuh {side:side}: Er zeigt {load_n:number} N, während er allein steht; so viel wiegt"
    " niemand. Prüfen Sie seine Kraftmesszellen und ihre Einheiten (Newton).",
    "shoes.of": "Schuh {side:side}. {reason}",
    "shoes.one_foot": "Der Gang hat nur einen Fuß; Kräfte brauchen beide.",
    "shoes.shank_swing": "Der Sensor am Unterschenkel schwingt nicht um eine Achse. Prüfen Sie, wie er angelegt"
    " ist.",
    "shoes.shank_twist": "Der Sensor am Unterschenkel dreht sich um die Längsachse des Beins. Prüfen Sie, wie er"
    " angelegt ist.",
    "shoes.stairs": "Kräfte werden nur auf ebenem Boden ausgewertet, und ein Doppelschritt (Fuß {side:side})"
    " steigt oder fällt um {rise_m:cm}.",
    "shoes.time_bases": "Die Sensoren eines Schuhs haben verschiedene Zeitachsen. Rechnen Sie sie auf eine um.",
    "shoes.uneven": "Die Messwerte eines Schuhs sind nicht gleichmäßig. Rechnen Sie sie auf eine gemeinsame Rate"
    " um.",
    "side.left": "links",
    "side.right": "rechts",
    "sign_in.bearer_only": "Verstanden wird nur `Authorization: Bearer` mit einem Geräteschlüssel.",
    "sign_in.busy": "Gerade melden sich viele Menschen an; versuchen Sie es erneut.",
    "sign_in.change_password_first": "Wählen Sie zuerst ein eigenes Passwort: Jemand anderes kennt das jetzige.",
    "sign_in.code_needed": "Tippen Sie den Code Ihrer Authenticator-App ein, oder einen Ihrer Ersatzcodes.",
    "sign_in.code_wrong": "Dieser Code ist falsch oder wurde schon benutzt. Warten Sie auf den nächsten.",
    "sign_in.csrf": "Der Kopf {header} fehlt oder ist falsch; lesen Sie ihn noch einmal von /api/me.",
    "sign_in.device_token_only": "Das ist für Gateways: Nötig ist ein Geräteschlüssel.",
    "sign_in.no_device_token": "Ein Geräteschlüssel gilt hier nicht; melden Sie sich an.",
    "sign_in.no_role": "Dieses Konto hat keine Rolle, die sich anmelden darf.",
    "sign_in.origin": "Diese Anfrage kam nicht von einer Seite dieses Dienstes (Origin falsch oder fehlend).",
    "sign_in.required": "Bitte melden Sie sich an.",
    "sign_in.second_factor_first": "Richten Sie zuerst die Anmeldung in zwei Schritten ein: Dieser Dienst"
    " verlangt sie.",
    "sign_in.ticket_refused": "Das Ticket gilt hier nicht, wurde schon benutzt oder ist älter als 30 Sekunden;"
    " fordern Sie ein neues an.",
    "sign_in.too_many": "Zu viele fehlgeschlagene Anmeldungen; versuchen Sie es in {seconds:s} erneut.",
    "sign_in.wrong": "Die E-Mail-Adresse oder das Passwort ist falsch.",
    "signal.check_columns": "Prüfen Sie seine Spalten und seine Einheit.",
    "signal.foot_gyroscope": "{where:place}: Das Gyroskop dreht nicht mehr als {raw:number~3} {unit}, obwohl der"
    " Beschleunigungssensor Schritte zeigt; ein gehender Fuß dreht mit 1 rad/s (57 Grad/s) oder mehr."
    " {advice}",
    "signal.gyroscope_fast": "{where:place}: Das Gyroskop zeigt {raw:number} {unit}, schneller als jeder Sensor"
    " misst. {advice}",
    "signal.no_earth_field": "{where:place}: Der Median des Magnetometers ist {raw:number~3} {unit}; erwartet"
    " wurde das Erdfeld (22 bis 67 µT). {advice}",
    "signal.iron_or_unit": "Eisen am Gerät sieht so aus: Drehen Sie den Sensor in der Aufzeichnung um alle Achsen, oder"
    " lassen Sie den Kompass weg. Eine andere Einheit sieht auch so aus: Geben Sie {units:or} nur an, wenn das Gerät"
    " sie liefert.",
    "signal.iron_or_columns": "Eisen am Gerät sieht so aus: Drehen Sie den Sensor in der Aufzeichnung um alle Achsen,"
    " oder lassen Sie den Kompass weg. Prüfen Sie sonst Spalten und Einheit.",
    "signal.no_gravity": "{where:place}: Der Median des Beschleunigungssensors ist {raw:number~3} {unit};"
    " erwartet wurde die Schwerkraft (9,81 m/s²). {advice}",
    "signal.no_numbers": "{where:place}: keine Zahlen für {quantity:quantity}.",
    "six_position.contradict": "Die Lagen widersprechen einander um {residual_mps2:mps2.2}. Nehmen Sie einen"
    " ebenen Tisch, und legen Sie den Sensor flach auf jede Seite.",
    "six_position.correction": "{triad:triad}: Nötig wäre eine Korrektur von {correction:percent}. Einheit,"
    " Bereich und Achsen prüfen, und ob jede Drehung ganz war, dann wiederholen.",
    "six_position.gap": "Der Teil von {start_s:s.1} bis {stop_s:s.1} ist nicht vollständig. Wiederholen Sie"
    " diesen Teil.",
    "six_position.incomplete": "Die Sechs-Lagen-Kalibrierung ist nicht vollständig. {wanted:lines}",
    "six_position.not_square": "Die Seiten weichen um {angle_rad:deg.1} von einem rechten Winkel ab. Halten Sie"
    " den Sensor gegen etwas Rechtwinkliges, und wiederholen Sie.",
    "six_position.rest_missing": "Legen Sie den Sensor 2 s still, so dass nach oben zeigt: {faces:and} (auf 25°"
    " genau).",
    "six_position.turn_again": "{turns:lines} Markieren Sie Tisch und Sensor, drehen Sie ihn um genau eine"
    " Umdrehung, und wiederholen Sie. War sie ganz, drehen Sie ihn noch zweimal: Zwei übereinstimmende"
    " Drehungen werden angenommen.",
    "six_position.turn_doubt_over": "Die Drehung um {axis} zeigte {error:percent.1} zu viel: wegen der Skala des"
    " Gyroskops, oder weil sie nicht ganz voll war. Eine zweite Drehung darum zeigt, was davon.",
    "six_position.turn_doubt_under": "Die Drehung um {axis} zeigte {error:percent.1} zu wenig: wegen der Skala"
    " des Gyroskops, oder weil sie nicht ganz voll war. Eine zweite Drehung darum zeigt, was davon.",
    "six_position.turn_missing": "Drehen Sie ihn um genau eine volle Umdrehung um {axes:and}, und lassen Sie ihn"
    " davor und danach 1 s auf derselben Seite still liegen.",
    "six_position.turn_over": "Die Drehung um {axis} zeigte {error:percent.1} zu viel, sie war also kaum eine"
    " ganze.",
    "six_position.turn_under": "Die Drehung um {axis} zeigte {error:percent.1} zu wenig, sie war also kaum eine"
    " ganze.",
    "six_position.unusable": "Diese sechs Lagen sind nicht verwendbar. {reasons:lines}",
    "source.impossible": "Diese Werte beschreiben keine tragbare Quelle. {reason}",
    "source.not_allowed": "Nur das Personal der Praxis kann ihre Magnetquellen verwalten.",
    "source.not_found": "Diese Magnetquelle wurde in Ihrer Praxis nicht gefunden.",
    "source_trouble.alone": "Die Quelle wird nicht verwendet; die Unsicherheit wächst.",
    "source_trouble.disturbed": "Eisen oder ein anderer Magnet ist in der Nähe; gehen Sie davon weg.",
    "source_trouble.fault": "Die Pulse passen zu keiner Position; prüfen Sie die Nummern der Spulen, und welches"
    " Modul wo ist.",
    "source_trouble.missing": "Angeforderte Pulse kommen nicht; prüfen Sie, ob die Quelle eingeschaltet ist.",
    "source_trouble.over": "Die Quelle wird wieder verwendet.",
    "source_trouble.saturated": "Das Magnetometer ist an seiner Grenze: Der Sensor ist zu nah an einer Spule.",
    "source_trouble.wiring": "Es pulsen Spulen, die die Quelle nicht hat; prüfen Sie ihre Nummern, und welches"
    " Modul die Quelle ist.",
    "state.analysed": "ausgewertet",
    "state.calibrating": "wird kalibriert",
    "state.closing": "wird beendet",
    "state.created": "angelegt",
    "state.failed": "fehlgeschlagen",
    "state.link_lost": "Signal verloren",
    "state.ready": "bereit",
    "state.recording": "zeichnet auf",
}
