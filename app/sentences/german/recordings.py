"""German sentences of recordings, repetitions, results, sessions and setups."""

from typing import Final

GERMAN: Final[dict[str, str | dict[str, str]]] = {
    "recording.no_samples": "Die Aufzeichnung hat keine brauchbaren Messwerte. Prüfen Sie die Datei und ihre"
    " Spaltenzuordnung.",
    "recording.span": "Die Zeitstempel reichen über {span_s:s}, aber kein Sensor hat mehr als {samples:number}"
    " Messwerte. Ein Stempel muss falsch sein: Prüfen Sie ihre Einheit, den ersten und den letzten.",
    "recording.tick_rate": "Die Rate ist {rate_hz:hz.1}; sie muss zwischen 1 und 10 000 Hz liegen.",
    "repetition.half_way": "Auf halbem Weg angehalten: {share:percent} der üblichen Bewegung.",
    "repetition.longer": "Viel länger als die anderen: {duration_s:s.1} statt etwa {usual_s:s.1}.",
    "repetition.lost": "Die Sensoren waren während dieser Wiederholung {lost_s:s.1} lang verloren.",
    "repetition.no_measurement": "Keine Messung während dieser Wiederholung.",
    "repetition.opposite": "In die entgegengesetzte Richtung bewegt wie die anderen.",
    "repetition.other_movement": "Eine andere Bewegung als die, die gemacht werden sollte.",
    "repetition.shorter": "Viel kürzer als die anderen: {duration_s:s.1} statt etwa {usual_s:s.1}.",
    "repetition.unlike": "Anders als die übrigen: Die Bewegung nahm einen anderen Weg.",
    "result.no_frames": "Dieses Ergebnis enthält keine Bewegungsdaten; werten Sie die Sitzung zuerst aus.",
    "result.no_movement": "Dieses Ergebnis enthält noch keine Bewegung; warten Sie, bis seine Auswertung fertig"
    " ist.",
    "result.no_sequence": "Eine Rotationsreihenfolge {sequence} gibt es nicht.",
    "result.not_complete": "Ein unvollständiges Ergebnis kann nicht verglichen werden; warten Sie, bis es"
    " vollständig ist.",
    "result.not_found": "Diese Sitzung hat kein solches Ergebnis.",
    "result.not_yet": "Diese Sitzung hat noch kein Ergebnis; warten Sie, bis ihre Auswertung fertig ist.",
    "second_factor.code_wrong": "Dieser Code ist falsch. Prüfen Sie, ob die Uhr des Telefons stimmt, und tippen"
    " Sie den neuesten Code ein.",
    "second_factor.is_on": "Die Anmeldung in zwei Schritten ist schon eingeschaltet; schalten Sie sie zuerst"
    " aus, um sie neu einzurichten.",
    "second_factor.not_begun": "Beginnen Sie mit dem Einrichten der Authenticator-App.",
    "series.other_kind": "Die Sensoren dieser Art von Sitzung messen das nicht.",
    "series.unknown": "Keine Sitzung hat {names:and}; es gibt {known:and}.",
    "service.no_process": "Im Moment kann kein Prozess gestartet werden; versuchen Sie es erneut.",
    "session.analysed": "Ausgewertet.",
    "session.move_live": "Eine Sitzung ist live oder wird ausgewertet; warten Sie, bis das beendet ist, und"
    " verschieben Sie sie dann.",
    "session.move_template": "Aus dieser Sitzung entstand die eigene Vorlage „{name}“ der Patientin oder des"
    " Patienten: Sie würde die Bewegung einer anderen Person zeigen. Ziehen Sie die Vorlage zurück und nehmen"
    " Sie zuerst eine andere auf.",
    "session.nothing_to_move": "Wählen Sie eine andere Akte oder eine andere Übung.",
    "session.reason_needed": "Schreiben Sie den Grund.",
    "session.moved": "Aus einer anderen Akte hierher verschoben. {reason}",
    "session.exercise_changed": "Die Übung dieser Sitzung wurde geändert. {reason}",
    "session.delete_live": "Diese Sitzung ist live; beenden Sie sie vor dem Löschen.",
    "session.headings_left_out": "Die bei {time_s:s} gesetzten Richtungen wurden nicht verwendet. {reason}",
    "slip.turned": "{where:place|or}: Der Sensor hat sich bei {at} anscheinend im Gurt verdreht, um etwa"
    " {angle_rad:deg}. Die Winkel von {joints:joint|and} sind danach nicht verlässlich. Befestigen Sie den Sensor neu,"
    " und kalibrieren Sie noch einmal.",
    "session.no_estimator": "Ein Schätzverfahren {unknown:or} gibt es nicht; wählen Sie {known:or}.",
    "session.no_packets": "Diese Sitzung enthält keine Daten: Es hat sich nie eine Sensorbox verbunden.",
    "session.no_pose": "Nicht kalibriert, deshalb gibt es keine Gelenkwinkel: Es wurde keine Kalibrierhaltung"
    " aufgezeichnet.",
    "session.no_samples": "Diese Sitzung enthält keine Messwerte.",
    "session.no_sensor": "Die Sitzung hat hier keinen Sensor: {places:place}.",
    "session.not_calibrated_because": "Nicht kalibriert, deshalb gibt es keine Gelenkwinkel. {reason}",
    "session.not_finished": "Diese Sitzung ist nicht fertig; warten Sie, bis sie ausgewertet ist.",
    "session.not_found": "Die Sitzung wurde nicht gefunden, oder sie ist nicht für Sie freigegeben.",
    "session.nothing_to_estimate": "Die Sitzung enthält keine auswertbaren Pakete.",
    "session.offline_estimator": "{wanted} braucht die ganze Sitzung. Zeichnen Sie mit {live} auf; {wanted}"
    " folgt, wenn die Sitzung endet.",
    "session.other_exercise": "Das ist nicht die verordnete Übung.",
    "session.other_prescription": "Die Verordnung gehört nicht zu dieser Person.",
    "session.parameter_type": "Eine Einstellung des Schätzverfahrens hat einen Wert der falschen Art.",
    "session.pose_found": "Kalibrierhaltung in der Aufzeichnung gefunden.",
    "session.pose_outside": "Die Haltung von {start_s:s.1} bis {end_s:s.1} liegt nicht in der Aufzeichnung.",
    "setup.arm_needs": "Arme, Rumpf und Beine brauchen einen Sensor an einem Oberarm oder Unterarm, oder Sensoren"
    " ober- und unterhalb einer Hüfte, eines Knies oder eines Sprunggelenks, oder am Rumpf und an beiden"
    " Oberschenkeln.",
    "setup.balance_needs": "Ein Gleichgewichtstest braucht einen Sensor am Becken, an der Brust oder an beiden,"
    " und keine anderen.",
    "setup.bursts_need": "Eine Aufzeichnung von Pulsgruppen braucht Magnetometer und Spulenzustände (Bits 2 und"
    " 6 der Paketmaske).",
    "setup.bursts_smoother": "Pulsgruppen brauchen Orientierungen der ganzen Aufzeichnung: {known:or}, nicht"
    " {name}.",
    "setup.coil_layers": "coil_layers sind zwei ganze Zahlen: Schleifen längs und quer zur Wicklung.",
    "setup.coil_limit": "Eine Magnetquelle am Körper muss unter {current_a:number~3} A und {moment_am2:number~3}"
    " A m² bleiben; diese Spulen tun das nicht.",
    "setup.coil_list": "calibrated_coils ist eine Liste von Spulen.",
    "setup.coil_numbers": "Windungen, Radius und Stromgrenze der Spulen müssen über null liegen.",
    "setup.gain_sigma": "Kalibrierte Spulen brauchen ihr gain_sigma: wie unsicher sie sind.",
    "setup.loops": "Eine Wicklung wird durch höchstens {most:number} Schleifen beschrieben.",
    "setup.missing_sensors": "In der Aufzeichnung fehlen Sensoren: {missing:place}. Sie hat: {worn:place}.",
    "setup.no_burst": "{where:place}: keine Pulsgruppe aus drei Spulen innerhalb von {longest_s:s.1} in"
    " {pulses:number} Pulsen. Pulse, die der Dienst einzeln angefordert hat, gehören zu einer Sitzung mit"
    " Magnetquelle.",
    "setup.no_placements": "Es wird kein Sensor getragen. Nennen Sie mindestens eine Stelle.",
    "setup.only_magnetic": "Nur Sitzungen mit Magnetquelle können so geglättet werden.",
    "setup.placement_twice": "Eine Stelle kommt zweimal vor ({places:place}). Jeder Sensor braucht seine eigene.",
    "setup.rate": "Die Rate ist {rate_hz:hz.1}; sie muss zwischen 10 und 1000 Hz liegen.",
    "setup.source_place": "Wählen Sie, wo die Magnetquelle getragen wird: {places:place|or}.",
    "setup.source_sensor": "Eine Sitzung mit Magnetquelle braucht die Quelle und mindestens einen Sensor, jeden"
    " an seiner eigenen Stelle.",
    "setup.three_coils": "Eine getragene Magnetquelle hat drei Spulen, nicht {coils:number}.",
    "setup.unknown_parameters": "Einstellungen, die es nicht gibt: {unknown:and}. Bekannt sind {known:and}.",
    "setup.unknown_pipeline": "Eine Auswertung {name} gibt es nicht. Verwenden Sie eine von: {known:or}.",
    "setup.unknown_placement": "Stellen, die es nicht gibt: {unknown:and}. Verwenden Sie eine von:"
    " {places:place|or}.",
    "measure_name.repetition.compensation": "Umfang",
    "measure_name.repetition.duration": "Dauer",
    "measure_name.repetition.duration_ratio": "Dauer gegenüber der Vorlage",
    "measure_name.repetition.hand_path_ratio": "Weg der Hand gegenüber einer geraden Linie",
    "measure_name.repetition.inside_band": "Anteil im Band",
    "measure_name.repetition.joint_common_share": "Gemeinsame Bewegung von Schulter und Ellbogen",
    "measure_name.repetition.joint_correlation": "Schulter und Ellbogen zusammen (Korrelation)",
    "measure_name.repetition.joint_lag": "Ellbogen hinter der Schulter",
    "measure_name.repetition.log_dimensionless_jerk": "Bewegungsfluss (logarithmischer Ruck)",
    "measure_name.repetition.mean_speed": "Mittlere Handgeschwindigkeit",
    "measure_name.repetition.mean_turning_speed": "Mittlere Drehgeschwindigkeit",
    "measure_name.repetition.movement_units": "Bewegungseinheiten",
    "measure_name.repetition.multiple_correlation": "Konsistenz (CMC)",
    "measure_name.repetition.path_residual": "Weg der Hand, Unterschied in der Form",
    "measure_name.repetition.path_scale": "Weg der Hand, Faktor zur Größe der Vorlage",
    "measure_name.repetition.path_turn": "Weg der Hand, gegen die Vorlage gedreht",
    "measure_name.repetition.peak_deviation": "größter Unterschied",
    "measure_name.repetition.peak_deviation_phase": "Phase des größten Unterschieds",
    "measure_name.repetition.peak_speed": "Höchste Handgeschwindigkeit",
    "measure_name.repetition.peak_turning_speed": "Höchste Drehgeschwindigkeit",
    "measure_name.repetition.range": "Bewegungsumfang",
    "measure_name.repetition.range_ratio": "Umfang gegenüber der Vorlage",
    "measure_name.repetition.repetition_rms": "Streuung der Wiederholungen",
    "measure_name.repetition.shape_deviation": "Unterschied in der Form",
    "measure_name.repetition.shape_rms": "Unterschied in der Form",
    "measure_name.repetition.spectral_arc_length": "Bewegungsfluss (SPARC)",
    "measure_name.repetition.time_to_peak_speed": "Zeit bis zur höchsten Geschwindigkeit, % der Hinbewegung",
    "measure_name.repetition.timing_deviation": "Ungleichmäßiges Tempo",
    "measure_name.repetition.units_per_metre": "Bewegungseinheiten je Meter",
}
