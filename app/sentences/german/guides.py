"""German sentences of guided calibration and guided exercises."""

from typing import Final

GERMAN: Final[dict[str, str | dict[str, str]]] = {
    "guidance.arm_in_front": "Den Arm vorn lassen.",
    "guidance.arm_not_across": "Nicht so weit vor den Körper.",
    "guidance.arm_not_back": "Nicht so weit nach hinten.",
    "guidance.arm_to_side": "Den Arm seitlich lassen.",
    "guidance.further": "Ein bisschen weiter.",
    "guidance.quicker": "Etwas schneller.",
    "guidance.shoulder_down": "Die Schulter unten lassen.",
    "guidance.sit_tall": "Aufrecht sitzen.",
    "guidance.slower": "Langsamer.",
    "guidance.stand_tall": "Aufrecht stehen.",
    "guidance.well_done": "Gut gemacht.",
    "guide_functional.elbow_flexion": "Bei hängendem Oberarm den Ellbogen dreimal ganz beugen und wieder"
    " strecken.",
    "guide_functional.elbow_flexion_title": "Ellbogen beugen",
    "guide_functional.pronation": "Bei angelegtem, gebeugtem Ellbogen die Handfläche dreimal nach oben und unten"
    " drehen.",
    "guide_functional.pronation_title": "Handfläche drehen",
    "guide_functional.raise_forward": "Den gestreckten Arm dreimal nach vorn bis auf Schulterhöhe heben und"
    " senken.",
    "guide_functional.raise_forward_title": "Nach vorn heben",
    "guide_functional.raise_sideways": "Den gestreckten Arm dreimal zur Seite bis auf Schulterhöhe heben und"
    " senken.",
    "guide_functional.raise_sideways_title": "Zur Seite heben",
    "guide_functional.rest": "Drei Sekunden aufrecht stehen mit hängenden Armen, Daumen nach vorn.",
    "guide_functional.rest_title": "Still stehen",
    "guide_functional.summary": "Bestimmt die eigenen Gelenkachsen, die genaueste Kalibrierung. Still stehen,"
    " dann die Ellbogen beugen, die Handflächen drehen und die Arme nach vorn und zur Seite heben.",
    "guide_functional.title": "Durch Bewegung",
    "guide_heading_reset.pose": "Aufrecht stehen, dieselbe Blickrichtung wie bei der Kalibrierung, Arme hängen,"
    " Handflächen an den Oberschenkeln, und stillhalten.",
    "guide_heading_reset.pose_title": "Arme hängen lassen",
    "guide_heading_reset.summary": "Setzt die Richtungen eines Arms oder Beins neu, wenn sie sich verschoben"
    " haben; die Kalibrierung bleibt. Zwei Sekunden mit hängenden Armen still stehen, dieselbe Blickrichtung"
    " wie bei der Kalibrierung.",
    "guide_heading_reset.title": "Richtungen setzen",
    "guide_magnetometer.summary": "Bestimmt, wie Eisen im Sensor das Magnetfeld verbiegt. Den Sensor langsam in"
    " alle Richtungen drehen, abseits von Eisen.",
    "guide_magnetometer.title": "Kompass kalibrieren",
    "guide_magnetometer.turn_all_ways": "Den Sensor langsam in alle Richtungen drehen, als würden Sie eine Kugel"
    " von innen anmalen, bis jedes Feld gefüllt ist.",
    "guide_magnetometer.turn_all_ways_title": "In alle Richtungen drehen",
    "guide_n_pose.pose": "Aufrecht stehen, Arme hängen, Handflächen an den Oberschenkeln, Daumen nach vorn, und"
    " stillhalten.",
    "guide_n_pose.pose_title": "Stehhaltung einnehmen",
    "guide_n_pose.summary": "Bestimmt, wie die Sensoren am Körper sitzen. Drei Sekunden mit hängenden Armen"
    " still stehen.",
    "guide_n_pose.title": "Stehhaltung",
    "guide_passive.elbow_flexion": "Den Ellbogen der Person dreimal beugen und strecken, so weit es ohne"
    " Schmerzen geht.",
    "guide_passive.elbow_flexion_title": "Den Ellbogen für die Person beugen",
    "guide_passive.pronation": "Die Handfläche der Person dreimal nach oben und unten drehen.",
    "guide_passive.pronation_title": "Die Handfläche für die Person drehen",
    "guide_passive.raise_forward": "Den Arm der Person dreimal nach vorn heben und senken.",
    "guide_passive.raise_forward_title": "Den Arm für die Person nach vorn heben",
    "guide_passive.raise_sideways": "Den Arm der Person dreimal zur Seite heben und senken.",
    "guide_passive.raise_sideways_title": "Den Arm für die Person zur Seite heben",
    "guide_passive.rest": "Drei Sekunden aufrecht sitzen, Oberarm hängt, Ellbogen gebeugt, Daumen nach oben; der"
    " Arm darf aufliegen.",
    "guide_passive.rest_title": "Still sitzen",
    "guide_passive.summary": "Für Menschen, die nicht stehen oder keine Haltung halten können: Jemand anderes"
    " bewegt den Arm, im Sitzen. Der halbe Umfang der aktiven Bewegungen genügt.",
    "guide_passive.title": "Sitzend, mit Hilfe",
    "guide_six_position.face_title": "Ablegen",
    "guide_six_position.face_x_down": "Den Sensor auf die Kante legen, x-Achse nach unten, und zwei Sekunden"
    " loslassen.",
    "guide_six_position.face_x_up": "Den Sensor auf die Kante legen, x-Achse nach oben, und zwei Sekunden"
    " loslassen.",
    "guide_six_position.face_y_down": "Den Sensor auf die Kante legen, y-Achse nach unten, und zwei Sekunden"
    " loslassen.",
    "guide_six_position.face_y_up": "Den Sensor auf die Kante legen, y-Achse nach oben, und zwei Sekunden"
    " loslassen.",
    "guide_six_position.face_z_down": "Den Sensor mit der bedruckten Seite nach unten legen und zwei Sekunden"
    " loslassen.",
    "guide_six_position.face_z_up": "Den Sensor mit der bedruckten Seite nach oben legen und zwei Sekunden"
    " loslassen.",
    "guide_six_position.summary": "Bestimmt Skala, Nullpunkt und Achsen von Beschleunigungssensor und Gyroskop"
    " eines Sensors; einmal für jeden Sensor nötig, und nach einem Sturz.",
    "guide_six_position.title": "Sechs Lagen",
    "guide_six_position.turn": "Achse {axis} nach oben oder unten: Markieren, wo er liegt, den Sensor auf dem"
    " Tisch um genau eine ganze Umdrehung drehen und ihn davor und danach still liegen lassen.",
    "guide_six_position.turn_title": "Um {axis} drehen",
    "guide_static_bias.rest": "Jeden Sensor auf einen Tisch legen, in beliebiger Lage, und nicht berühren.",
    "guide_static_bias.rest_title": "Sensoren ablegen",
    "guide_static_bias.summary": "Bestimmt, was die Gyroskope in Ruhe anzeigen. Alle Sensoren fünf Sekunden auf"
    " einen Tisch legen; erst tun, wenn sie warm sind.",
    "guide_static_bias.title": "Gyroskop-Nullpunkt",
    "guide_t_pose.pose": "Aufrecht stehen, beide Arme auf Schulterhöhe gerade zur Seite, Handflächen nach unten,"
    " und stillhalten.",
    "guide_t_pose.pose_title": "T-Haltung einnehmen",
    "guide_t_pose.summary": "Wie die Stehhaltung, mit zur Seite gestreckten Armen; braucht funktionierende"
    " Kompasse.",
    "guide_t_pose.title": "T-Haltung",
    "guided.after_walk": "Ein Gang wird erst danach mit seiner Vorlage verglichen: Währenddessen wird nichts gezählt.",
    "guided.attempt_count": "Ein Satz ist beendet: Die in der Therapie festgelegte Zahl der Versuche ist"
    " erreicht.",
    "guided.cannot": "Die Vorlage bewegt sich zu wenig, um ihr zu folgen; die Sitzung läuft ohne Anleitung"
    " weiter.",
    "guided.ended": "Die Übung wurde beendet; beginnen Sie eine neue Sitzung.",
    "guided.main_not_measured": "{channel:channel}, die wichtigste Messgröße dieser Übung, wird nicht gemessen: Es wird"
    " nichts gezählt und nichts angesagt. Legen Sie die Sensoren über und unter dem Gelenk an.",
    "guided.failed": "Die Anleitung ist ausgefallen und beendet; die Sitzung läuft ohne sie weiter.",
    "guided.limit_at_rest": "{channel:channel} liegt schon in Ruhe bei {value}, jenseits der Grenze von {limit}: Diese"
    " Grenze hält die Sitzung nicht an. Ändern Sie die Grenze.",
    "guided.limit": "Angehalten: jenseits der in der Therapie festgelegten Grenze.",
    "guided.lost": "Unterbrochen: Der Bewegung kann nicht gefolgt werden.",
    "guided.pain": "Von der übenden Person angehalten: Es tut weh.",
    "guided.partial": "Teilweise Wiederholung {number}",
    "guided.paused": "Von Hand unterbrochen.",
    "guided.resumed": "Die Übung geht weiter.",
    "guided.set": "Ein Satz ist geschafft; Pause, bis die übende Person weitermacht.",
    "guided.stopped": "Von Hand angehalten.",
    "guided.time": "Die verordnete Zeit ist um.",
    "guided.unsure": "Unterbrochen: Die Bewegung ist nicht genau genug bekannt.",
    "guided.valid": "Gültige Wiederholung {number}",
    "guided.valid_count": "Die verordneten Wiederholungen sind geschafft.",
    "guided.wrong": "Andere Bewegung {number}",
    "guided.wrong_in_a_row": "Unterbrochen: mehrere andere Bewegungen hintereinander.",
}
