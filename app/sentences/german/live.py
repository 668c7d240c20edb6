"""German sentences of live sessions, logs and magnetic sources."""

from typing import Final

GERMAN: Final[dict[str, str | dict[str, str]]] = {
    "live.account_inactive": "Dieses Konto ist nicht mehr aktiv.",
    "live.all_sent": "Die Sensorbox hat alles gesendet.",
    "live.behind": "Die Schätzung ist im Rückstand; warten Sie einen Moment.",
    "live.calibrated": "Kalibriert, {score:points} von 100 Punkten.",
    "live.calibration_cancelled": "Die Kalibrierung wurde abgebrochen.",
    "live.calibration_done": "{kind:calibration_kind} fertig, {score:points} von 100 Punkten.",
    "live.calibration_stays": "Die frühere Kalibrierung gilt weiter. {reason}",
    "live.cannot_calibrate": "Zum Kalibrieren müssen Sensoren verbunden sein und darf keine Aufzeichnung laufen;"
    " beenden Sie die Aufzeichnung, oder verbinden Sie zuerst.",
    "live.being_analysed": "Diese Sitzung wird gerade ausgewertet; versuchen Sie es gleich noch einmal.",
    "live.reopened": "Wartet auf Messungen, die noch nicht gesendet wurden.",
    "live.closed": "Diese Sitzung ist beendet; erstellen Sie eine neue.",
    "live.closed_by_person": "Sitzung beendet.",
    "live.closed_idle": "Von selbst beendet: Zehn Minuten lang kamen keine Daten.",
    "live.closed_incomplete": "Beendet: Die Sensorbox sendet nicht mehr, und einige Daten kamen nie an.",
    "live.closed_long": "Von selbst beendet: Die Sitzung hat die längste erlaubte Zeit erreicht. Erstellen Sie"
    " eine neue Sitzung, um fortzufahren.",
    "live.connected": "Verbunden.",
    "live.connected_calibrate": "Verbunden; kalibrieren Sie, wenn die Haltung eingenommen ist.",
    "live.connected_directions": "Verbunden. Die Sensorlage ist vom letzten Mal gespeichert; setzen Sie die"
    " Richtungen, bevor gemessen wird.",
    "live.connection_ended": "Die Verbindung zur Sensorbox wurde beendet.",
    "live.directions_left": "Die Richtungen müssen noch gesetzt werden: {places:place}.",
    "live.estimation_failed": "Die Live-Schätzung ist ausgefallen. Was die Sensoren senden, wird gespeichert und"
    " kann danach ausgewertet werden.",
    "live.force_back": "Die Kraftmesszellen des Schuhs messen wieder ({side:side}).",
    "live.force_implausible": "Die Werte der Kraftmesszellen des Schuhs ({side:side}) sind nicht plausibel;"
    " prüfen Sie die Messzellen.",
    "live.force_lost": "Keine Daten von den Kraftmesszellen des Schuhs ({side:side}).",
    "live.full": "Es sind so viele Sitzungen live, wie dieser Rechner ohne Verzögerung trägt. Die Sensoren"
    " verbinden sich von selbst, wenn eine andere endet.",
    "live.functional_sensors": "Die Kalibrierung durch Bewegung braucht Sensoren an Oberarm und Unterarm"
    " derselben Seite.",
    "live.gap": "{missing_s:s.2} an Daten fehlen.",
    "live.gap_hold": "Einen Moment lang fehlten Daten; bleiben Sie still.",
    "live.good_still": "Gut, still bleiben.",
    "live.magnetic_uncalibrated": "Eine Sitzung mit Magnetquelle braucht keine Kalibrierhaltung; stehen Sie drei"
    " Sekunden still.",
    "live.moved": "Still bleiben; bewegt hat sich: {sensors:place}.",
    "live.movement_not_ended": "Die Bewegung wurde nie beendet; beginnen Sie noch einmal, und drücken Sie nach"
    " jeder Bewegung „Fertig, weiter“.",
    "live.movement_too_short": "Machen Sie die Bewegung zuerst dreimal; das dauert mindestens {least_s:s}.",
    "live.network_changed": "Diese Sitzung begann mit anderen Sensoren (Stellen, Rate, Skalen oder Grenzwerte);"
    " verbinden Sie dieselben, oder beenden Sie sie und erstellen Sie eine neue.",
    "live.never_still": "Es war nie {hold_s:s} lang still; beginnen Sie noch einmal, wenn alles bereit ist.",
    "live.no_magnetometer": "Diese Sensoren haben kein Magnetometer, oder die Sensorbox sendet es nicht.",
    "live.no_packet": "Seit {silence_s:s} keine Daten von den Sensoren.",
    "live.no_sensor_of_limb": "An diesem Arm oder Bein wird kein Sensor getragen; wählen Sie ein anderes"
    " Körperteil.",
    "live.no_step": "Keine Kalibrierung wartet auf einen Schritt; beginnen Sie eine.",
    "live.not_closed": "Die Sitzung konnte nicht ordentlich beendet werden; was gespeichert ist, ist sicher."
    " Werten Sie sie noch einmal aus.",
    "live.not_connected": "Mit dieser Sitzung sind keine Sensoren verbunden; schalten Sie zuerst die Sensorbox ein.",
    "live.not_evaluated": "Diese Kalibrierung konnte nicht ausgewertet werden; die frühere gilt weiter."
    " Wiederholen Sie sie.",
    "live.not_recording": "Es wird nichts aufgezeichnet.",
    "live.of_sensor": "{place:place}. {what}",
    "live.other_placements": "Die verbundenen Sensoren sind nicht die der Sitzung ({places:place}); erstellen"
    " Sie die Sitzung für die getragenen Sensoren.",
    "live.pose": "Aufrecht stehen, Arme hängen, Handflächen an den Oberschenkeln, und stillhalten.",
    "live.preparing": "Der Dienst wird für diese Art von Sitzung vorbereitet, was nach einer Installation oder"
    " Aktualisierung bis zu einer Minute dauert. Die Sensoren verbinden sich danach von selbst.",
    "live.record_first": "Die Aufzeichnung beginnt, wenn die Sitzung bereit ist: verbunden und kalibriert.",
    "live.recording_stopped": "Aufzeichnung beendet.",
    "live.rest_ends_itself": "Dieser Schritt endet von selbst; still bleiben.",
    "live.restarted": "Der Dienst wurde neu gestartet.",
    "live.sends_nothing": "Keine Daten von: {sensors:place}. Prüfen Sie, ob jeder Sensor eingeschaltet und in"
    " der Nähe ist.",
    "live.settling": "Still bleiben; die Sensoren beruhigen sich.",
    "live.source_allowed": "Die Quelle darf Pulse abgeben.",
    "live.source_not_stopped": "Die Magnetquelle gibt Pulse ab, obwohl sie angehalten wurde. Schalten Sie sie"
    " von Hand aus.",
    "live.state": "Die Sitzung kann nicht von „{state:state}“ zu „{following:state}“ wechseln.",
    "live.step_ends_itself": "Dieser Schritt endet von selbst; folgen Sie der Anweisung.",
    "live.still_evaluating": "Die letzte Kalibrierung wird noch ausgewertet; warten Sie einen Moment.",
    "live.stopped": "Der Dienst wurde angehalten.",
    "live.stopping": "Der Dienst hält gerade an; verbinden Sie noch einmal.",
    "live.stray_source": "In dieser Sitzung ohne Magnetquelle gibt eine Magnetquelle Pulse ab; sie werden nicht"
    " verwendet, und niemand wurde nach Implantaten gefragt. Schalten Sie sie aus, oder erstellen Sie eine"
    " Sitzung mit Magnetquelle.",
    "live.superseded": "Eine neuere Verbindung hat diese Sitzung übernommen.",
    "live.ticket_first": "Melden Sie sich an, oder senden Sie als erste Nachricht ein Ticket.",
    "live.ticket_message": "Die erste Nachricht muss ein JSON-Objekt mit dem Feld ticket sein.",
    "live.token_expired": "Der Geräteschlüssel wurde entzogen oder ist abgelaufen.",
    "live.too_long": "Es dauerte länger als zehn Minuten; beginnen Sie noch einmal.",
    "live.turned_too_far": "Die Drehung um {axis} war {excess_rad:deg} mehr als eine ganze. Markieren Sie den"
    " Anfang, und drehen Sie ihn noch einmal um genau eine Umdrehung. War sie genau, drehen Sie ihn trotzdem"
    " noch einmal: Zwei übereinstimmende Drehungen werden angenommen.",
    "live.turned_too_little": "Die Drehung um {axis} war {missing_rad:deg} weniger als eine ganze. Markieren Sie"
    " den Anfang, und drehen Sie ihn noch einmal um genau eine Umdrehung. War sie genau, drehen Sie ihn"
    " trotzdem noch einmal: Zwei übereinstimmende Drehungen werden angenommen.",
    "live.unknown_mark": "Diese Art von Sitzung kennt keine Markierung {label}; verwenden Sie {known:or}.",
    "live.walk_uncalibrated": "Ein Gang braucht keine Kalibrierung; drei Sekunden still stehen und gehen.",
    "load_cell.forefoot": "Vorfuß",
    "load_cell.heel": "Ferse",
    "log.cut_off": "Das Protokoll endet in Paket {number}; es ist abgeschnitten.",
    "log.cut_off_in_hello": "Das Protokoll endet in seinem Hello; es ist abgeschnitten.",
    "log.hello_incomplete": "Dem Hello am Anfang des Protokolls fehlen Stellen, Rate oder Skalen.",
    "log.hello_not_json": "Das Hello am Anfang des Protokolls ist kein JSON-Objekt.",
    "log.hello_refused": "Das Hello des Protokolls ist nicht verwendbar. {reason}",
    "log.hello_too_long": "Das Hello des Protokolls gibt {length} Bytes an; erlaubt sind höchstens {most}.",
    "log.no_packet": "Das Protokoll enthält kein unversehrtes Paket.",
    "log.not_a_log": "Die Datei beginnt nicht mit TML1: Sie ist kein Telemotion-Paketprotokoll. Wählen Sie das"
    " richtige Format.",
    "log.packet_length": "Paket {number} gibt {length} Bytes an; das Protokoll ist dort beschädigt.",
    "magnetic.event_confirmed": "Sicherheit bestätigt: keine Implantate.",
    "magnetic.event_withdrawn": "Sicherheitsbestätigung zurückgenommen; die Quelle darf keine Pulse abgeben.",
    "magnetic.expired": "Die Sicherheitsbestätigung für die Magnetquelle ist abgelaufen; bevor die Quelle Pulse"
    " abgeben darf, muss jemand aus der Therapie erneut bestätigen, dass niemand in der Nähe ein Implantat"
    " trägt.",
    "magnetic.no_source": "Diese Sitzung hat keine Magnetquelle.",
    "magnetic.not_confirmed": "Diese Sitzung hat eine Magnetquelle: Bevor sie beginnen kann, muss jemand aus der"
    " Therapie bestätigen, dass weder die behandelte Person noch Menschen in der Nähe einen"
    " Herzschrittmacher oder ein ähnliches Implantat tragen.",
    "magnetic.not_confirmed_yet": "Für diese Sitzung gibt es keine Sicherheitsbestätigung; die Quelle darf keine"
    " Pulse abgeben.",
    "magnetic.nothing_to_confirm": "Diese Sitzung hat keine Magnetquelle; es gibt nichts zu bestätigen.",
    "magnetic.nothing_to_withdraw": "Diese Sitzung hat keine Magnetquelle; es gibt nichts zurückzunehmen.",
    "magnetic.one_estimator": "Eine Sitzung mit Magnetquelle hat ein Schätzverfahren, und das ist schon gelaufen.",
    "magnetic.only_magnetic": "Nur eine Sitzung mit Magnetquelle hat eine Quelle.",
    "magnetic.result_of_walk": "Dieses Ergebnis gehört zum Gang; wählen Sie eines der Magnetquelle.",
    "magnetic.warning": "Die Quelle erzeugt Magnetpulse. Niemand mit einem Herzschrittmacher, einem"
    " implantierten Defibrillator, einem Nervenstimulator, einem Cochlea-Implantat oder einer"
    " Medikamentenpumpe darf sie tragen oder nahe bei ihr sein, während sie getragen wird.",
    "magnetic.withdrawn": "Die Sicherheitsbestätigung für die Magnetquelle wurde zurückgenommen; die Quelle darf"
    " keine Pulse abgeben, bis jemand aus der Therapie erneut bestätigt, dass niemand in der Nähe ein"
    " Implantat trägt.",
}
