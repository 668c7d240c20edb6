"""German sentences of accounts, balance, calibration, devices and the service as a whole."""

from typing import Final

GERMAN: Final[dict[str, str | dict[str, str]]] = {
    "account.change_not_allowed": "Nur die Verwaltung der Praxis kann Konten ändern.",
    "account.create_not_allowed": "Nur die Verwaltung der Praxis kann Konten anlegen.",
    "account.email_form": "Geben Sie eine vollständige E-Mail-Adresse ein, zum Beispiel name@example.org.",
    "account.email_taken": "Es gibt schon ein Konto mit dieser E-Mail-Adresse.",
    "account.list_not_allowed": "Nur das Personal der Praxis kann ihre Konten auflisten.",
    "account.no_such_patient": "Diese Person wurde in der Praxis nicht gefunden.",
    "account.not_found": "Dieses Konto wurde in Ihrer Praxis nicht gefunden.",
    "account.own": "Das ist Ihr eigenes Konto: Abschalten kann es nur jemand anderes aus der Verwaltung; um Ihr"
    " Passwort zu ändern, geben Sie das jetzige ein.",
    "account.password_changed_elsewhere": "Das Passwort wurde gerade in einem anderen Browser geändert; melden"
    " Sie sich erneut an.",
    "account.password_same": "Das neue Passwort ist das jetzige; wählen Sie ein anderes.",
    "account.password_wrong": "Das jetzige Passwort ist falsch.",
    "account.patient_id": "Ein Konto mit der Rolle patient braucht patient_id; Konten mit anderen Rollen dürfen"
    " es nicht haben.",
    "balance.eyes_closed_firm": "Augen geschlossen, fester Boden",
    "balance.eyes_closed_foam": "Augen geschlossen, Schaumstoff",
    "balance.eyes_open_firm": "Augen offen, fester Boden",
    "balance.eyes_open_foam": "Augen offen, Schaumstoff",
    "balance.no_test": "Diese Sitzung ist kein Gleichgewichtstest; zeichnen Sie einen mit Sensoren an Becken und"
    " Brust auf.",
    "balance.nothing_marked": "Während der Aufzeichnung wurde nichts markiert: Sie zählt im Ganzen als ein Test"
    " des Stehens.",
    "balance.one_link": "Die Verschiebung ist die der Hüften, {height_m:m.2} über den Knöcheln, wenn sich der"
    " Körper als ein steifes Glied um die Knöchel bewegt; wer in der Hüfte beugt, bewegt sich weniger als"
    " gezeigt.",
    "balance.reach": "Nach vorn reichen",
    "balance.rest": "Ende des Tests",
    "balance.too_short": "Zu kurz: {shortest_s:s} oder mehr ohne Lücke sind nötig.",
    "bench.no_coils": "Die Pakete dieser Sitzung haben keine Spulenzustände oder kein Magnetometer (Bits 6 und"
    " 2).",
    "bench.no_fit": "Die Spulen konnten nicht bestimmt werden. {reason}",
    "bench.no_sensor": "Die Sitzung hat keinen Sensor an dieser Stelle: {place:place}.",
    "bench.no_stop": "keine",
    "bench.places": "Der Sensor lag an {stops} Stellen still ({times:and}), angegeben wurden aber {places}."
    " Geben Sie für jede eine an, und lassen Sie Bewegungen dazwischen weg.",
    "bench.singular": "Die Stellen bestimmen sie nicht.",
    "bench.time": "{start_s:number} bis {end_s:s}",
    "bench.too_long": "Diese Sitzung ist länger als eine Stunde, das Höchste für eine Kalibrierung auf der"
    " Werkbank.",
    "bench.weak": "Diese Stellen bestimmen das Feld nur auf ±{sigma:percent}. Legen Sie den Sensor an mehr"
    " Stellen und näher: 10 bis 25 cm von der Mitte, auf jeder Seite.",
    "body.stature": "Eine Körpergröße von {stature_m:m.2} liegt außerhalb von 0,5 bis 2,5 m. Geben Sie Meter an,"
    " nicht Zentimeter.",
    "c3d.cut_off": "Die C3D-Datei ist abgeschnitten: Sie kündigt {frames:number} Bilder an und enthält weniger."
    " Exportieren Sie sie noch einmal.",
    "c3d.damaged": "Die Parameter dieser C3D-Datei sind beschädigt; exportieren Sie sie noch einmal.",
    "c3d.no_frames": "Die C3D-Datei enthält keine Bilder.",
    "c3d.no_unit": "Die C3D-Datei nennt die Einheit ihrer Punkte nicht; exportieren Sie sie mit {units:or}.",
    "c3d.not_c3d": "Das ist keine C3D-Datei; wählen Sie das Format, das sie hat.",
    "c3d.points": "Die C3D-Datei enthält {points:number} Punkte; verwendbar sind 1 bis {most:number}.",
    "c3d.processor": "Das Zahlenformat {processor} dieser C3D-Datei ist unbekannt; exportieren Sie sie mit"
    " Intel-Zahlen.",
    "c3d.rate": "Die C3D-Datei nennt eine Rate von {rate_hz:hz~3}, was nicht möglich ist; exportieren Sie sie"
    " noch einmal.",
    "c3d.unit": "Die C3D-Datei gibt ihre Punkte in {unit} an; exportieren Sie sie mit {units:or}.",
    "calibration.arm_no_compass": "Arm {side:side}: Er hat keinen Kompass, deshalb muss eine Bewegung seine"
    " Richtung zeigen. Arm nach vorn heben, dann wiederholen.",
    "calibration.at_limit": "{where:place}: Messwerte lagen im Stehen an der Grenze des Bereichs. Prüfen Sie den"
    " Bereich.",
    "calibration.compasses_apart": "Die Kompasse ({where:place}) weichen um {angle_rad:deg} voneinander ab."
    " Gehen Sie weg von Eisen, kalibrieren Sie sie, und wiederholen Sie.",
    "calibration.contradiction": "Arm {side:side}: Ruhe und Bewegungen widersprechen einander um"
    " {angle_rad:deg}. Mit hängendem Arm beginnen und wiederholen.",
    "calibration.elbow_hardly_bent": "Ellbogen {side:side}: Er wurde kaum gebeugt, deshalb ist die Ausrichtung"
    " der Sensoren von der Art des Anlegens übernommen. Beugen Sie ihn in einer Aufzeichnung einige Male.",
    "calibration.elbow_measured": "Arm {side:side}: Die Ausrichtung der Sensoren wurde durch Beugen des"
    " Ellbogens gemessen, auf etwa {sigma_rad:deg}.",
    "calibration.elbow_uncertain": "Arm {side:side}: Die Ausrichtung der Sensoren ist von der Art des Anlegens"
    " übernommen; das Beugen des Ellbogens hat sie nur auf {sigma_rad:deg} gemessen.",
    "calibration.faces_away": "{where:place}: Die anderen Sensoren zeigen um {angle_rad:deg} in eine andere"
    " Richtung als dieser. Wenn ihre bedruckten Seiten nach außen zeigen, prüfen Sie diesen.",
    "calibration.faces_backward": "{where:place}: Der Sensor zeigt nach hinten. Das ist hier erlaubt, aber"
    " prüfen Sie, ob es der richtige ist.",
    "calibration.facing_by_other": "{where:place}: Der Sensor liegt flach. Die Blickrichtung wurde stattdessen"
    " hier gemessen: {by:place}.",
    "calibration.facing_unknown": "Die Blickrichtung ist nicht bekannt, weil die Sensoren ({where:place}) flach"
    " liegen. Drehen Sie die bedruckte Seite von einem davon vom Körper weg, und wiederholen Sie.",
    "calibration.flat": "{where:place}: Der Sensor liegt flach. Drehen Sie seine bedruckte Seite vom Körper weg.",
    "calibration.flat_no_compass": "{where:place}: Der Sensor liegt flach und hat keinen Kompass, deshalb ist"
    " seine Richtung nicht zu finden. Drehen Sie seine bedruckte Seite vom Körper weg, und wiederholen Sie.",
    "calibration.forgotten": "Die Haltung ist mehr als {memory_s:s} her. Nehmen Sie sie noch einmal 3 s lang ein.",
    "calibration.gravity_fault": "{where:place}: Der Beschleunigungssensor weicht in Ruhe um {error:percent} von"
    " der Schwerkraft ab. Prüfen Sie Einheit und Bereich, oder tauschen Sie den Sensor aus.",
    "calibration.gravity_off": "{where:place}: Der Beschleunigungssensor weicht um {error:percent} ab."
    " Kalibrieren Sie ihn.",
    "calibration.hardly_moved": "Arm {side:side}: Er hat sich kaum bewegt: {kind:movement}. Weiter bewegen und"
    " wiederholen.",
    "calibration.iron_near": "{where:place}: Eisen oder ein Magnet ist in der Nähe. Gehen Sie davon weg, und"
    " wiederholen Sie.",
    "calibration.just_started": "{where:place}: Die Messung hatte gerade erst begonnen. Warten Sie 3 s, und"
    " wiederholen Sie.",
    "calibration.knee_hardly_moved": "Das Knie hat sich kaum bewegt. Beugen und strecken Sie es fünfmal zügig.",
    "calibration.leg_twisted": "Das Bein hat sich um seine Längsachse gedreht. Beugen Sie das Knie, ohne das"
    " Bein zu verdrehen.",
    "calibration.leg_two_axes": "Das Bein hat sich um mehr als eine Achse gedreht. Beugen Sie das Knie, ohne den"
    " Fuß zu drehen.",
    "calibration.level_arms": "Die Sensoren an den Armen haben keinen Kompass, und waagerecht gehaltene Arme"
    " zeigen die Richtung nicht. Nehmen Sie stattdessen die Stehhaltung mit hängenden Armen ein.",
    "calibration.magnetic_needs_none": "Eine Sitzung mit Magnetquelle braucht keine Kalibrierhaltung. Drei"
    " Sekunden still stehen.",
    "calibration.moved": "{where:place}: Bewegung während der Ruhe. Alles ablegen oder still stehen, und"
    " wiederholen.",
    "calibration.movement_missing": "Arm {side:side}: Es fehlt eine Bewegung: {kind:movement}. Wiederholen Sie"
    " mit dieser Bewegung.",
    "calibration.movement_small": "Arm {side:side}: Er hat sich nur um {angle_rad:deg} bewegt: {kind:movement}."
    " Um mindestens {least_rad:deg} bewegen und wiederholen.",
    "calibration.movements_tell_nothing": "Diese Bewegungen können nicht jeden Sensor kalibrieren:"
    " {where:place}. Nehmen Sie diesen Sensor ab, oder kalibrieren Sie beide Arme.",
    "calibration.movements_unusable": "Diese Bewegungen sind nicht verwendbar. {reasons:lines}",
    "calibration.nearly_flat": "{where:place}: Der Sensor liegt fast flach. Legen Sie ihn aufrecht an.",
    "calibration.no_arm_moved": "Kein Arm mit Sensoren an Oberarm und Unterarm hat die Bewegungen gemacht."
    " Ellbogen beugen und Handfläche drehen, dann wiederholen.",
    "calibration.no_data": "{where:place}: Während der Haltung kamen keine Daten vom Sensor. Prüfen Sie, ob er"
    " eingeschaltet und in der Nähe ist, und wiederholen Sie.",
    "calibration.no_devices": "Einzelne Sensoren können in dieser Art von Sitzung nicht kalibriert werden.",
    "calibration.no_directions": "In dieser Art von Sitzung werden die Richtungen nicht durch eine Haltung"
    " gesetzt.",
    "calibration.no_joints": "Diese Sensoren messen kein Gelenk, es gibt also nichts durch Bewegung zu"
    " kalibrieren.",
    "calibration.no_rest_found": "Es gibt keinen Moment von 1,5 s, in dem alle Sensoren ruhig sind. Zeichnen Sie"
    " die Kalibrierhaltung auf, 3 s still stehen mit hängenden Armen, oder geben Sie an, wann sie"
    " eingenommen wurde.",
    "calibration.not_checked": "Noch nicht durch eine Bewegung geprüft: Nur eine Kalibrierung durch Bewegung"
    " zeigt, ob sich die Sensoren drehen wie der Körper.",
    "calibration.not_level": "Ein Sensor liegt nicht waagerecht mit der bedruckten Seite nach oben. Legen Sie"
    " alle auf einen ebenen Tisch, und wiederholen Sie.",
    "calibration.not_raised": "Die Arme wurden nicht gehoben, deshalb ist die Blickrichtung von der Art des"
    " Anlegens der Sensoren übernommen.",
    "calibration.not_settled": "{where:place}: Der Sensor hat sich noch nicht beruhigt ({angle_rad:deg} neben"
    " der Schwerkraft). 3 s in der Haltung warten und wiederholen.",
    "calibration.not_still": "{where:place}: Der Sensor war nicht ruhig. Wiederholen Sie die Haltung.",
    "calibration.not_worn": "Hier wird kein Sensor getragen: {where:place}.",
    "calibration.off_pose": "{where:place}: Der Sensor weicht um {angle_rad:deg} von der Stehhaltung ab. Arme"
    " hängen lassen, Handflächen an den Oberschenkeln, und wiederholen.",
    "calibration.other_sensors": "{where:place}: Die Kalibrierung umfasst diesen Sensor nicht. Kalibrieren Sie"
    " noch einmal mit allen angelegten Sensoren.",
    "calibration.pose_moved": "{where:place}: Der Sensor hat sich um {angle_rad:deg} bewegt. Mit hängenden Armen"
    " still stehen und wiederholen.",
    "calibration.pose_outside": "Die Haltung von {start_s:s.1} bis {stop_s:s.1} liegt nicht in der Aufzeichnung.",
    "calibration.pose_unusable": "Diese Haltung ist nicht verwendbar. {reasons:lines}",
    "calibration.put_on": "{where:place}: Ohne Kompass ist die Richtung von der Art des Anlegens übernommen,"
    " bestenfalls auf ±{sigma_rad:deg} genau. Kalibrieren Sie durch Bewegung, um sie zu messen.",
    "calibration.raises_apart": "Die Arme wurden in Richtungen gehoben, die nicht zueinander passen. Gerade nach"
    " vorn und gerade zur Seite heben, und wiederholen.",
    "calibration.reset_needs_one": "Richtungen können erst nach einer Kalibrierung neu gesetzt werden. Nehmen"
    " Sie die Stehhaltung ein.",
    "calibration.rest_missing": "Der Moment der Ruhe fehlt. Vor den Bewegungen 3 s stillhalten.",
    "calibration.same_signals": "Die Sensoren ({where:place}) senden dasselbe Signal, bis in das Rauschen: Ein"
    " Sensor kommt unter mehreren Namen. Prüfen Sie, wie die Sensorbox ihre Sensoren dem Körper zuordnet, und"
    " kalibrieren Sie dann noch einmal.",
    "calibration.seat_moved": "{where:place}: Der Sensor hat sich um {angle_rad:deg} bewegt. Still sitzen und"
    " wiederholen.",
    "calibration.single_sensors": "Einzelne Sensoren haben keine Haltung. Legen Sie sie ab, und bestimmen Sie"
    " stattdessen ihren Gyroskop-Nullpunkt.",
    "calibration.swayed": "{where:place}: Der Sensor hat geschwankt. Still stehen und wiederholen.",
    "calibration.swung": "Arm {side:side}: Er schwang herum, statt sich zu heben. Gerade auf und ab bewegen:"
    " {kind:movement}.",
    "calibration.too_few_samples": "{where:place}: Es kamen nur {samples:number} brauchbare Messwerte an."
    " Mindestens {least_s:s} ruhen, bei stetigem Signal.",
    "calibration.turned_steadily": "{where:place}: stetige Drehung mit mehr als {limit_radps:degps}. Stillhalten"
    " und wiederholen.",
    "calibration.uncertain": "{where:place}: Die Richtung des Sensors ist auf {sigma_rad:deg} unsicher. Größere"
    " Bewegungen messen sie besser.",
    "calibration.unusual_zero": "{where:place}: Das Gyroskop zeigt in Ruhe mehr als {limit_radps:degps}."
    " Entweder hat es sich langsam gedreht, oder es ist ein schlechtes Gyroskop: Legen Sie den Sensor auf"
    " einen Tisch, der sich nicht bewegt, und bestimmen Sie den Gyroskop-Nullpunkt.",
    "calibration.walk_needs_none": "Ein Gang braucht keine Kalibrierhaltung. Eine Sekunde still stehen, dann"
    " gehen.",
    "calibration.was_moving": "{where:place}: Der Sensor hat sich bewegt. Mit hängenden Armen still stehen und"
    " wiederholen.",
    "calibration_kind.functional": "Kalibrierung durch Bewegung",
    "calibration_kind.heading_reset": "Setzen der Richtungen",
    "calibration_kind.magnetometer": "Kompasskalibrierung",
    "calibration_kind.n_pose": "Stehhaltung",
    "calibration_kind.passive": "Kalibrierung im Sitzen",
    "calibration_kind.six_position": "Sechs-Lagen-Kalibrierung",
    "calibration_kind.static_bias": "Gyroskop-Nullpunkt",
    "calibration_kind.t_pose": "T-Haltung",
    "caseload.compensation_angle": "{channel:channel}: {more_rad:deg} mehr als in der Vorlage.",
    "caseload.compensation_length": "{channel:channel}: {more_m:cm} mehr als in der Vorlage.",
    "caseload.dead_link": "Die Verbindung zu den Sensoren war länger als {silence_s:s} unterbrochen.",
    "caseload.dead_to_the_end": "Die Verbindung zu den Sensoren brach ab und kam nicht zurück.",
    "caseload.declining": {
        "one": "{channel:channel}: hat innerhalb von {count} Woche wahrscheinlich abgenommen.",
        "other": "{channel:channel}: hat innerhalb von {count} Wochen wahrscheinlich abgenommen.",
    },
    "caseload.declining_angle": {
        "one": "{channel:channel}: wahrscheinlich {less_rad:deg} ± {half_rad:deg} weniger als vor {count} Woche.",
        "other": "{channel:channel}: wahrscheinlich {less_rad:deg} ± {half_rad:deg} weniger als vor {count} Wochen.",
    },
    "caseload.failed": "Die letzte Sitzung ist fehlgeschlagen.",
    "caseload.few_repetitions": "{valid} von {count} verordneten Wiederholungen waren in der letzten Sitzung"
    " gültig.",
    "caseload.link_lost": "Eine Sitzung ist offen, aber von den Sensoren kommen keine Daten.",
    "caseload.lost": "In der letzten Sitzung gingen {share:percent} der Pakete verloren.",
    "caseload.much_pain": "Schmerzen {mark} von 10 nach der Sitzung.",
    "caseload.no_template": "Eine Übung ist ohne Vorlage zum Vergleichen verordnet.",
    "caseload.not_practising": {
        "one": "Seit {count} Tag nichts geübt.",
        "other": "Seit {count} Tagen nichts geübt.",
    },
    "caseload.rarely_practised": "{share:percent} der Sitzungen der letzten vier Wochen wurden gemacht.",
    "caseload.pain": "Die Sitzung wurde abgebrochen, weil es wehtat.",
    "caseload.pain_corrected": "{before} Später in {mark} von 10 geändert.",
    "caseload.pain_marked": "Die Sitzung wurde abgebrochen, weil es wehtat; Schmerzen {mark} von 10.",
    "channel.axial_rotation": "Schulterrotation (axial)",
    "channel.elbow_carrying": "Armaußenwinkel",
    "channel.elbow_flexion": "Ellbogenflexion",
    "channel.elbow_x": "Ellbogen nach vorn",
    "channel.elbow_y": "Ellbogen nach links",
    "channel.elbow_z": "Ellbogen nach oben",
    "channel.elevation": "Schulterelevation",
    "channel.forearm_pronation": "Unterarmpronation",
    "channel.ankle_flexion": "Dorsalextension des Sprunggelenks",
    "channel.ankle_inversion": "Inversion des Sprunggelenks",
    "channel.ankle_rotation": "Innenrotation des Fußes",
    "channel.foot_height": "Fußhöhe",
    "channel.foot_pitch": "Fußneigung",
    "channel.foot_speed": "Fußgeschwindigkeit nach vorn",
    "channel.hand_x": "Hand nach vorn",
    "channel.hand_y": "Hand nach links",
    "channel.hand_z": "Hand nach oben",
    "channel.hip_abduction": "Hüftabduktion",
    "channel.hip_flexion": "Hüftflexion",
    "channel.hip_rotation": "Hüftinnenrotation",
    "channel.knee_abduction": "Knieabduktion",
    "channel.knee_flexion": "Knieflexion",
    "channel.knee_rotation": "Knieinnenrotation",
    "channel.plane_of_elevation": "Elevationsebene der Schulter",
    "channel.shoulder_hike": "Schulterhochzug",
    "channel.trunk_forward_lean": "Rumpfneigung nach vorn",
    "channel.trunk_rotation": "Rumpfrotation",
    "channel.trunk_sideways_lean": "Rumpfneigung zur Seite",
    "channel.wrist_deviation": "Handgelenkdeviation",
    "channel.wrist_flexion": "Handgelenkflexion",
    "channel.wrist_rotation": "Handgelenkrotation",
    "channel.wrist_x": "Handgelenk nach vorn",
    "channel.wrist_y": "Handgelenk nach links",
    "channel.wrist_z": "Handgelenk nach oben",
    "clinic.change_not_allowed": "Nur die Verwaltung kann die Praxis ändern.",
    "clinic.no_such_zone": "Diese Zeitzone gibt es nicht; wählen Sie eine aus der Liste, zum Beispiel"
    " Europe/Oslo.",
    "compare.cut_short": "Gespeichertes ({kind:stored}) ist abgeschnitten oder größer als jedes echte. Erstellen"
    " Sie es neu.",
    "compare.damaged": "Gespeichertes ({kind:stored}) ist beschädigt. Erstellen Sie es neu.",
    "compare.few_repetitions": {
        "one": "Es wurde nur eine brauchbare Wiederholung gefunden. Zeichnen Sie mindestens zwei auf, besser"
        " fünf, mit einer kurzen Ruhe dazwischen.",
        "other": "Es wurden {count:number} brauchbare Wiederholungen gefunden. Zeichnen Sie mindestens zwei"
        " auf, besser fünf, mit einer kurzen Ruhe dazwischen.",
    },
    "compare.no_signal": "Seite {side:side}: Kein Gelenkwinkel und kein Handgelenk wurde gemessen. Sensoren ober-"
    " und unterhalb des Gelenks anlegen und kalibrieren.",
    "compare.not_measured": "{channel:channel}: nicht gemessen. Wählen Sie eines von: {channels:channel|or}.",
    "compare.not_stored": "Diese Bytes sind nicht, was gespeichert sein sollte ({kind:stored}).",
    "compare.other_version": "Gespeichertes ({kind:stored}) hat eine andere Form ({version}), als dieses"
    " Programm liest ({known}). Aktualisieren Sie das Programm.",
    "compare.side_not_measured": "Seite {side:side}: In dieser Aufzeichnung wurde nichts davon gemessen. Sensoren"
    " anlegen und kalibrieren, oder die andere Seite vergleichen.",
    "compare.other_side_measured": "Seite {side:side}: In dieser Aufzeichnung wurde nichts davon gemessen, die Sensoren"
    " waren auf der anderen Seite angelegt ({worn:side}). Sensoren auf der Seite der Übung anlegen und kalibrieren,"
    " oder die Übung der anderen Seite wählen.",
    "comparison.done": "Verglichene Wiederholungen: {kept} von {all}.",
    "comparison.no_template": "Es ist keine Vorlage verordnet, deshalb gab es keinen Vergleich.",
    "comparison.not_compared": "Nicht verglichen. {reason}",
    "comparison.not_practised": "Diese Sitzung zählt nicht als geübt. {reason}",
    "comparison.not_found": "Der Vergleich wurde nicht gefunden, oder er ist nicht für Sie freigegeben.",
    "compass.all_visited": "Alle Richtungen wurden abgedeckt.",
    "compass.axes_turned": "Die Achsen des Magnetometers sind um {angle_rad:deg} gegen die des"
    " Beschleunigungssensors verdreht. Prüfen Sie die Achsen von beiden.",
    "compass.begin": "Drehen Sie den Sensor langsam in alle Richtungen, als würden Sie eine Kugel von innen"
    " anmalen.",
    "compass.circle_off": "Die Messwerte weichen um {residual:percent} von einem Kreis ab. Wiederholen Sie"
    " abseits von Eisen und Magneten.",
    "compass.few_directions": "Nur {coverage:percent} der Richtungen wurden abgedeckt. {hint}",
    "compass.few_samples": "Nur {samples:number} Messwerte kamen an. Zwei volle Drehungen von mindestens 5 s"
    " machen und wiederholen.",
    "compass.field_constant": "Das Magnetfeld hat sich kaum verändert. Drehen Sie den Sensor zweimal ganz um die"
    " Senkrechte, abseits von Eisen.",
    "compass.hard_iron_only": "Nur {coverage:percent} der Richtungen wurden abgedeckt, deshalb wurde nur die"
    " Hartmagnetik bestimmt. {hint}",
    "compass.hardly_level": "Der waagerechte Teil des Magnetfelds beträgt nur {level_t:ut}. Richtungen nach dem"
    " Kompass werden hier unsicher sein.",
    "compass.hardly_turned": "Der Sensor wurde kaum gedreht. Langsam in alle Richtungen drehen und wiederholen.",
    "compass.heading_uncertain": "Die Richtung ist auf {sigma_rad:deg.1} unsicher. {hint}",
    "compass.heading_unknown": "Die Richtung wäre noch auf {sigma_rad:deg} unsicher. {hint}",
    "compass.level_turns_only": "Waagerechte Drehungen bestimmen die Hartmagnetik nur quer zur Senkrechten."
    " Drehen Sie den Sensor in alle Richtungen.",
    "compass.next_turn": "Drehen Sie den Sensor so, dass seine Achse {axis} nach Norden und unten zeigt, und"
    " schwenken Sie ihn dort.",
    "compass.no_data": "Das Magnetometer lieferte keine Daten. Prüfen Sie, ob es eingeschaltet ist.",
    "compass.norm_implausible": "Das Magnetfeld beträgt hier {norm_t:ut}; das der Erde beträgt {low_t:ut} bis"
    " {high_t:ut}. Gehen Sie weg von Eisen, Magneten und Lautsprechern, und kalibrieren Sie noch einmal.",
    "compass.norm_varies": "Die Stärke des Feldes schwankt noch um {residual:percent}. Wiederholen Sie abseits"
    " von Eisen und Magneten.",
    "compass.not_uniform": "Das Magnetfeld ist hier nicht gleichmäßig ({residual:percent} Abweichung). Gehen Sie"
    " weg von Eisen, Magneten und Lautsprechern, drehen Sie den Sensor auf der Stelle, und wiederholen Sie.",
    "compass.odd_dip": "Dieser Sensor sah ein anderes Magnetfeld als die übrigen ({norm_t:ut}, Neigung"
    " {dip_rad:deg}, gegenüber {others_t:ut}, Neigung {others_dip_rad:deg}). Kalibrieren Sie ihn noch"
    " einmal, abseits von Eisen.",
    "compass.odd_field": "Dieser Sensor sah ein anderes Magnetfeld als die übrigen ({norm_t:ut} gegenüber"
    " {others_t:ut}). Kalibrieren Sie ihn noch einmal, abseits von Eisen.",
    "compass.part_of_turn": "Nur {angle_rad:deg} einer ganzen Drehung waren zu sehen. Zwei volle Drehungen"
    " machen und wiederholen.",
    "compass.points_down": "Das Magnetfeld zeigt um {angle_rad:deg} nach unten; auf der Südhalbkugel zeigt es"
    " nach oben. Gehen Sie weg von Eisen, oder prüfen Sie die Vorzeichen des Sensors.",
    "compass.points_up": "Das Magnetfeld zeigt um {angle_rad:deg} nach oben; auf der Nordhalbkugel zeigt es nach"
    " unten. Gehen Sie weg von Eisen, oder prüfen Sie die Vorzeichen des Sensors.",
    "compass.tilted": "Der Sensor war beim Drehen geneigt. Waagerecht halten, um die Senkrechte drehen und"
    " wiederholen.",
    "compass.unusable": "Diese Kompasskalibrierung ist nicht verwendbar. {reasons:lines}",
    "edited.elsewhere": "Jemand anderes hat dies geändert, seit Sie es geöffnet haben. Laden Sie es neu; Ihre Eingaben"
    " sind noch hier.",
    "edited.meanwhile": "{name} hat dies geändert, nachdem Sie es geöffnet hatten. Nichts von Ihnen wurde"
    " gespeichert und nichts ist verloren: Sehen Sie sich die Änderung an und speichern Sie dann noch einmal.",
    "prescription.of_template": "In der Vorlage: {trouble}",
    "prescription.has_ended": "Diese Verordnung ist beendet; verordnen Sie die Übung neu.",
    "template.changed_meanwhile": "{name} hat Version {number} gespeichert, nachdem Sie diese geöffnet hatten:"
    " „{reason}“. Nichts ist verloren: Sehen Sie sich die Version an und speichern Sie Ihre dann darauf.",
    "design.band_narrow": "Das Band von {channel:channel} ist zu eng: {left} von {of} Wiederholungen der eigenen"
    " Aufnahme der Vorlage verlassen es, um bis zu {excess}. Machen Sie es breiter.",
    "design.limit_above": "Halteregel {number}: In der eigenen Aufnahme der Vorlage erreicht {channel:channel} {value};"
    " diese Grenze würde jede Wiederholung anhalten. Setzen Sie sie auf {least} oder mehr.",
    "design.limit_below": "Halteregel {number}: In der eigenen Aufnahme der Vorlage geht {channel:channel} bis {value}"
    " hinunter; diese Grenze würde jede Wiederholung anhalten. Setzen Sie sie auf {least} oder weniger.",
    "design.limit_channel": "Halteregel {number}: {channel:channel} ist keine Kurve der Vorlage, also kann auf die"
    " Grenze nicht geachtet werden. Wählen Sie einen anderen Winkel.",
    "design.rest_above": "Halteregel {number}: In Ruhe liegt {channel:channel} bei dieser Person bei {value}; diese"
    " Grenze würde die Übung anhalten, bevor sie beginnt. Setzen Sie sie auf {least} oder mehr.",
    "design.rest_below": "Halteregel {number}: In Ruhe liegt {channel:channel} bei dieser Person bei {value}; diese"
    " Grenze würde die Übung anhalten, bevor sie beginnt. Setzen Sie sie auf {least} oder weniger.",
    "design.time_short": "Halteregel {number}: Eine Wiederholung der Vorlage dauert {lasts_s:s.1}; diese Zeit ist"
    " um, bevor die erste endet. Setzen Sie eine längere Zeit.",
    "design.cue": "Hinweis {number} ist ungültig; geben Sie ihm eine Kurve der Vorlage, Phasen in ihrer"
    " Reihenfolge und eine Toleranz über null.",
    "design.knots": "Die Punkte eines Bandes müssen geordnet und an verschiedenen Phasen sein, ein Band je"
    " Kurve; laden Sie die Vorlage noch einmal, und zeichnen Sie neu.",
    "design.main_counts": "{name} ist der Hauptwinkel der Übung und zählt immer; er kann nicht nur beobachtet"
    " werden.",
    "design.no_channel": "Die Vorlage hat keine Kurve {name}; wählen Sie eine, die sie zeigt.",
    "design.phases": "Phasen müssen aufeinander folgen, jede mit eigenem Namen und ihrem Beginn vor ihrem Ende;"
    " verschieben Sie die Grenze, die über einer anderen liegt.",
    "design.stop": "Halteregel {number} ist ungültig; geben Sie ihr einen Winkel der Vorlage und eine"
    " Grenze über null.",
    "design.weight": "Teil {number} der Summe ist ungültig; wählen Sie eine der angebotenen Messgrößen, jede"
    " einmal, und ein anderes Gewicht als null.",
    "device.code_refused": "Dieser Kopplungscode ist falsch, wurde schon benutzt oder ist älter als zehn"
    " Minuten; erstellen Sie einen neuen.",
    "device.no_open_session": "Für diese Person ist keine Sitzung offen. Erstellen Sie eine, und fragen Sie dann"
    " noch einmal.",
    "device.token_not_found": "Der Geräteschlüssel wurde nicht gefunden, oder er ist nicht für Sie freigegeben.",
    "device.token_refused": "Der Geräteschlüssel ist ungültig, abgelaufen oder entzogen; bitten Sie die Praxis"
    " um einen neuen.",
    "device.too_many_codes": "Zu viele falsche Kopplungscodes; versuchen Sie es in {seconds:s} erneut.",
    "dose.repetitions": {
        "one": "{count} Wiederholung",
        "other": "{count} Wiederholungen",
    },
    "dose.sets": "{sets} Sätze mit {amount}",
    "dose.walk": "1 Gang",
    "dose.weekly": {
        "one": "{amount}, einmal pro Woche",
        "other": "{amount}, {count}\u2011mal pro Woche",
    },
    "edge.body_too_large": "Die Anfrage ist größer als die Grenze von {limit_bytes:mib~3}.",
    "edge.body_too_slow": "Die Anfrage stockte oder kam {patience_s:s} lang zu langsam; senden Sie sie noch"
    " einmal.",
    "edge.database_busy": "Die Datenbank ist ausgelastet oder nicht erreichbar; versuchen Sie es gleich noch"
    " einmal.",
    "edge.fields": "Die Anfrage ist nicht gültig; prüfen Sie: {fields:and}.",
    "edge.method": "Diese Adresse nimmt nur {allowed} an.",
    "edge.metrics": "Messzahlen sind für den Betrieb des Dienstes: Setzen Sie TELEMOTION_METRICS_TOKEN, und"
    " senden Sie es als `Authorization: Bearer`.",
    "edge.no_accuracy": "Diese Installation hat keinen Genauigkeitsbericht; erstellen Sie einen mit `telemotion"
    " validate`.",
    "edge.no_json": "Der Inhalt ist nicht als JSON lesbar.",
    "edge.no_such_address": "Unter dieser Adresse gibt es nichts.",
    "edge.no_such_file": "Diese Datei gibt es nicht.",
    "edge.no_such_page": "Das ist keine Seite dieser Liste; lesen Sie die Liste von Anfang an.",
    "edge.host": "Dieser Dienst heißt anders; öffnen Sie ihn unter seiner eigenen Adresse.",
    "edge.query_nul": "Die Abfrage darf kein NUL enthalten; entfernen Sie %00.",
    "edge.unexpected": "Im Dienst ist etwas schiefgegangen; der Fehler wurde festgehalten.",
    "exercise.angle": "Der Hauptwinkel ist kein Gelenkwinkel der Seite {side:side}; wählen Sie einen aus der"
    " Liste.",
    "exercise.create_not_allowed": "Nur Therapie und Verwaltung können Übungen anlegen oder ändern.",
    "exercise.not_found": "Diese Übung wurde in Ihrer Praxis nicht gefunden.",
    "exercise.walk_angle": "Ein Gang hat keinen Hauptwinkel; lassen Sie ihn leer.",
    "caseload.due": "{name}: {dose}",
    "caseload.due_also": "{before}; {name}: {dose}",
}
