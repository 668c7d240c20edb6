"""German sentences of walks."""

from typing import Final

GERMAN: Final[dict[str, str | dict[str, str]]] = {
    "walk.aloft": "Fuß {side:side}: {away_s:s} lang bewegte er sich, ohne wie beim Gehen zu stehen. Das wird"
    " nicht gezählt.",
    "walk.count_short": "{missing_s:s.1} an Messwerten fehlen: Die Strecke ist wohl zu kurz, und in der Zählung"
    " können Schritte, Wendungen oder Halte fehlen.",
    "walk.ended_above": "Fuß {side:side}: Er endete {rise_m:m} über dem Anfang. Wenn es keine Treppe gab, prüfen"
    " Sie Einheiten, Achsen und Abtastrate der Aufzeichnung.",
    "walk.ended_below": "Fuß {side:side}: Er endete {rise_m:m} unter dem Anfang. Wenn es keine Treppe gab,"
    " prüfen Sie Einheiten, Achsen und Abtastrate der Aufzeichnung.",
    "walk.feet_only": "Die Füße werden durch eine Magnetquelle an einem Fuß und einen Sensor am anderen in"
    " Beziehung gesetzt, durch nichts anderes.",
    "walk.feet_unrelated": "Die Lage der Füße zueinander ist nicht bekannt. {reason}",
    "walk.few_footholds": "Jeder Fuß muss mindestens {least:number}\u2011mal stehen, bevor die Füße in Beziehung"
    " gesetzt werden können. Gehen Sie weiter.",
    "walk.forces_partly": "Kräfte sind nur von {start_s:s.1} bis {end_s:s.1} bekannt: {lost_s:s.1} lang kamen"
    " keine brauchbaren Daten von: {places:place}.",
    "walk.hole": "Die Messwerte eines Fußes haben ein Loch von {hole_s:s}. Schneiden Sie die Aufzeichnung dort.",
    "walk.in_both": "Ein Gang ist in beiden Bedingungen; wählen Sie verschiedene.",
    "walk.long_strides": {
        "one": "Fuß {side:side}: Ein Doppelschritt dauerte viel länger als die um ihn herum und wird nicht"
        " gezählt: ein Halt, oder zwei Doppelschritte, die für einen gehalten wurden.",
        "other": "Fuß {side:side}: {count:number} Doppelschritte dauerten viel länger als die um sie herum und"
        " werden nicht gezählt: Halte, oder je zwei Doppelschritte, die für einen gehalten wurden.",
    },
    "walk.missing": {
        "one": "Fuß {side:side}: {missing_s:s.1} an Messwerten fehlen; der Doppelschritt dort ist nicht in"
        " den Mittelwerten.",
        "other": "Fuß {side:side}: {missing_s:s.1} an Messwerten fehlen; die {count:number} Doppelschritte dort"
        " sind nicht in den Mittelwerten.",
    },
    "walk.needs_foot": "Ein Gang braucht einen Sensor an einem Fuß: {places:place|or}.",
    "walk.no_chair": "Die Füße messen Aufstehen und Hinsetzen nicht: Die Zeit läuft vom ersten Schritt bis zum"
    " letzten.",
    "walk.no_forces": "Es gibt keine Kräfte. {reason}",
    "walk.no_forces_from": "Es gibt keine Kräfte, denn keine brauchbaren Daten kamen von: {places:place}.",
    "walk.no_forces_together": "Es gibt keine Kräfte: Die vier Kraftmesszellen maßen nie gleichzeitig.",
    "walk.no_straight_stride": "Fuß {side:side}: Es gibt keinen Doppelschritt durchgehend geraden Gehens. Gehen"
    " Sie mindestens vier Doppelschritte.",
    "walk.no_stride": "Fuß {side:side}: Es wurde kein Doppelschritt gefunden. Er stand nie zwischen seinen"
    " Bewegungen, oder er verließ nie den Boden.",
    "stride.aloft": "Der Fuß war zu lange in Bewegung, ohne zu stehen; sein Weg ist nicht bekannt.",
    "stride.last": "Der letzte Doppelschritt vor dem Stehenbleiben.",
    "stride.long": "Viel länger als die Doppelschritte ringsum: ein Halt oder ein Stand, der nicht gefunden wurde.",
    "stride.missing": "In oder neben diesem Doppelschritt fehlen Messwerte.",
    "stride.sideways": "Ein Schritt zur Seite oder zurück.",
    "stride.turning": "In einer Kurve gegangen.",
    "stride.unsteady": "Nicht gleichmäßig oder nicht geradeaus.",
    "walk.no_strides": "Dieses Ergebnis hat keine Doppelschritte: Ein Live-Ergebnis hat keine, und eine"
    " Auswertung läuft vielleicht noch.",
    "walk.no_turn": "Es wurde keine Wendung gefunden.",
    "walk.no_walk": "Diese Sitzung ist kein Gang; zeichnen Sie einen mit Sensoren an den Füßen auf, oder laden"
    " Sie einen hoch.",
    "walk.not_analysed": "Eine gewählte Sitzung ist kein ausgewerteter Gang dieser Person.",
    "walk.not_six_minutes": "{walked_s:min.1} von sechs Minuten gegangen.",
    "walk.one_estimator": "Ein Gang hat ein Schätzverfahren, und das ist schon gelaufen; ein anderes gibt es"
    " nicht zu wählen.",
    "walk.one_foot": "Nur ein Fuß: kein beidbeiniger Stand und keine Asymmetrie.",
    "walk.one_foot_steps": "Nur ein Fuß: Für den anderen werden ebenso viele Schritte angenommen.",
    "walk.only_turns": {
        "one": "Fuß {side:side}: Jeder Doppelschritt wendet, keiner ist gerade; der eine in Wendungen ist"
        " {length_m:m.2} lang und dauert {duration_s:s.2}. Gehen Sie ein gerades Stück von mindestens vier"
        " Doppelschritten.",
        "other": "Fuß {side:side}: Jeder Doppelschritt wendet, keiner ist gerade; die {count:number} in"
        " Wendungen sind {length_m:m.2} lang und dauern {duration_s:s.2}. Gehen Sie ein gerades Stück von"
        " mindestens vier Doppelschritten.",
    },
    "walk.other_foot": "Fuß {side:side}: {missing_s:s.1} an Messwerten fehlen. Strecke und Schritte sind die des"
    " anderen Fußes.",
    "walk.rate": "Einem Fuß kann mit {rate_hz:hz.1} nicht gefolgt werden. Verwenden Sie 30 bis 2000 Hz.",
    "walk.rises_apart": "Vom Anfang bis zum Ende stieg der linke Fuß um {left_m:m.2} und der rechte um"
    " {right_m:m.2}, was ein Mensch nicht kann. Trauen Sie den Höhen nicht. Prüfen Sie Einheiten, Achsen und"
    " Abtastrate der Aufzeichnung.",
    "walk.short_way": "Der Gang ist kürzer als {least_m:m}; das ist zu kurz, um die Füße in Beziehung zu setzen.",
    "walk.sideways": {
        "one": "Fuß {side:side}: Ein Doppelschritt ging zur Seite oder zurück und wird nicht gezählt.",
        "other": "Fuß {side:side}: {count:number} Doppelschritte gingen zur Seite oder zurück und werden nicht"
        " gezählt.",
    },
    "walk.source_saw_few": "Die Magnetquelle sah {seen:number} von {count:number} Standphasen des rechten Fußes,"
    " zu wenige, um die Füße in Beziehung zu setzen.",
    "walk.too_fast": "Fuß {side:side}: {speed_mps:number.1} m/s ist schneller, als irgendjemand geht. Prüfen Sie"
    " Einheiten, Achsen und Abtastrate der Aufzeichnung.",
    "walk.too_long": "Fuß {side:side}: Doppelschritte von {length_m:m} sind länger als die irgendeines gehenden"
    " Menschen. Prüfen Sie Einheiten, Achsen und Abtastrate der Aufzeichnung.",
    "walk.too_short": "Ein Fuß braucht mindestens {least_s:s.1} an Messwerten; diese Aufzeichnung ist zu kurz.",
    "stride.outside": "Vor dem Beginn oder nach dem Ende der Aufzeichnung.",
    "walk.trembling": "Fuß {side:side}: Er zittert, während er steht, wie bei einem Klonus. Doppelschritte können"
    " fehlen, und Längen und Unterschiede zwischen den Füßen sind weniger sicher.",
    "walk.backward": "Es ging rückwärts. Aufsetzen und Abheben sind die von Rückwärtsschritten; vergleichen Sie die"
    " Zahlen nicht mit denen des Vorwärtsgehens.",
    "walk.carried": "Fuß {side:side}: Er stand nicht, während der andere ging, als würde er getragen. Es gibt keine"
    " Schrittlängen, keinen beidbeinigen Stand und keine Asymmetrie.",
    "walk.carried_way": "Fuß {side:side}: Er wurde getragen. Strecke und Schritte sind die des anderen Fußes.",
    "walk.counts_apart": "Der linke Fuß machte {left:number} Doppelschritte und der rechte {right:number}; das können"
    " zwei Füße, die abwechselnd gehen, nicht. Doppelschritte eines Fußes wurden nicht gefunden.",
    "walk.ways_apart": "Fuß {side:side}: Nur {way_m:m} Strecke wurden gefunden, vom anderen Fuß {other_m:m}. Es"
    " fehlen Doppelschritte; Strecke und Schritte sind die des anderen Fußes.",
    "walk.exchanged": "Beide Füße zeigen nach innen: der linke um {left_rad:deg}, der rechte um {right_rad:deg}. Sind"
    " der linke und der rechte Schuh vertauscht?",
    "walk.rolled": "{moved_s:s} lang bewegten sich die Füße, ohne zu gehen, wie im Rollstuhl, auf einem Fahrrad"
    " oder einer Rolltreppe. Diese Strecke wird nicht gezählt.",
    "worry.not_found": "Das steht nicht mehr in der Liste; laden Sie die Seite neu.",
    "measure_name.walk.cadence": "Kadenz",
    "measure_name.walk.centre_to_left": "Seitliche Verlagerung des Körperschwerpunkts, im Gehen",
    "measure_name.walk.clearance": "Bodenfreiheit in der Schwungphase",
    "measure_name.walk.double_support_share": "Zweibeinstand, % des Doppelschritts",
    "measure_name.walk.margin": "Stabilitätsreserve, kleinste je Sekunde",
    "measure_name.walk.speed": "Gehgeschwindigkeit, gleichmäßige Doppelschritte",
    "measure_name.walk.stance_share": "Standphase, Anteil am Doppelschritt",
    "measure_name.walk.step_width": "Schrittbreite",
    "measure_name.walk.stride_length": "Doppelschrittlänge, gleichmäßige Doppelschritte",
    "measure_name.walk.test_distance": "Strecke, ganzer Gang",
    "measure_name.walk.test_time": "Dauer des Tests, ganzer Gang",
    "measure_name.walk.toe_out": "Zehen nach außen gedreht",
    "measure_name.walk.walk_ratio": "Verhältnis von Schrittlänge zu Schritten pro Sekunde",
    "measure_name.walk.weight_on_left": "Gewicht auf dem linken Fuß, im Stehen",
    "measure_name.uneven.stance_share": "Standphase, links gegenüber rechts",
    "measure_name.uneven.step_time": "Schrittdauer, links gegenüber rechts",
    "measure_name.uneven.stride_length": "Doppelschrittlänge, links gegenüber rechts",
}
