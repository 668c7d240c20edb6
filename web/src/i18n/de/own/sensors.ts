// Words of measuring without a box: with the phone itself, or with sensors that the browser connects.
import type { Translated } from '../..';
import type { sensors as english } from '../../en/own/sensors';

export const sensors: Translated<typeof english> = {
  'sensors.title': 'Kein Gerät zur Hand?',
  'sensors.again': 'Hat dieses Gerät gemessen?',
  'sensors.phone': 'Dieses Telefon',
  'sensors.phoneText': 'In einem Band um Ihren Oberarm.',
  'sensors.bluetooth': 'Bluetooth-Sensoren',
  'sensors.bluetoothText': 'Sensoren, mit denen sich dieses Telefon oder dieser Computer direkt verbindet.',
  'sensors.box': 'Ein neues Gerät',
  'sensors.boxText': 'Ein Gerät verbinden, das Sie noch nicht benutzt haben.',
  'sensors.boxSteps':
    'Schalten Sie das Gerät ein. Drücken Sie dann den Knopf: Sie bekommen einen Code, den das Gerät einliest oder den Sie dort eintippen. Von da an macht es bei Ihren Übungen von selbst mit.',
  'sensors.boxHelp':
    'Lassen Sie das Gerät das Bild einlesen, oder tippen Sie den Code dort ein. Er gilt einmal, bis {time}.',
  'sensors.boxLabel': 'Gerät zu Hause',
  'sensors.boxGo': 'Code anzeigen',
  'sensors.back': 'Mit etwas anderem messen',
  'sensors.phoneStrap':
    'Stecken Sie das Telefon in sein Band, außen am Arm ({place}), in der Mitte zwischen Schulter und Ellbogen.',
  'sensors.phoneTight': 'Ziehen Sie das Band fest: Das Telefon darf nicht verrutschen, wenn Sie sich bewegen.',
  'sensors.phoneStart': 'Drücken Sie den Knopf, bevor Sie das Band schließen, und lassen Sie diese Seite offen.',
  'sensors.phoneSees': 'Das Telefon erkennt, wie weit Sie den Arm heben, wie oft und wie gleichmäßig.',
  'sensors.phoneSeesNot': 'Es erkennt nicht Ihren Ellbogen, Ihre Hand, wohin Sie greifen oder ob Sie sich neigen.',
  'sensors.phoneGo': 'Mit diesem Telefon messen',
  'sensors.dotSteps':
    'Drücken Sie auf eine Stelle und wählen Sie dann den Sensor, den Sie dort tragen. Seine Nummer ist aufgedruckt.',
  'sensors.dotChoose': 'Verbinden: {place}',
  'sensors.dotAgain': 'Ein anderer',
  'sensors.dotAgainFor': 'Ein anderer Sensor für: {place}',
  'sensors.dotMissing': {
    one: 'Ein Sensor ist noch nicht verbunden.',
    other: '{count} Sensoren sind noch nicht verbunden.',
  },
  'sensors.status.connecting': 'wird verbunden',
  'sensors.status.measuring': 'misst',
  'sensors.status.lost': 'verloren, wird gesucht',
  'sensors.status.failed': 'kann nicht benutzt werden',
  'sensors.battery': 'Akku {percent} %',
  'sensors.link.connecting': 'Verbindung zu Ihrer Praxis wird hergestellt',
  'sensors.link.open': 'Es wird gemessen. Alles wird an Ihre Praxis gesendet.',
  'sensors.link.behind': 'Es wird gemessen. Auf diesem Gerät gespeichert und gerade beim Senden: {seconds}.',
  'sensors.link.lost':
    'Keine Verbindung. Ihre Bewegung wird auf diesem Gerät gespeichert und später gesendet. Machen Sie mit Ihrer Übung weiter.',
  'sensors.link.blocked':
    'Dieses Netzwerk lässt die Verbindung zu Ihrer Praxis nicht durch. Ihre Bewegung wird auf diesem Gerät gespeichert und später gesendet. Nutzen Sie ein anderes Netzwerk, zum Beispiel mobile Daten, oder wenden Sie sich an die Netzwerkbetreuung.',
  'sensors.link.refused': 'Ihre Praxis nimmt die Bewegung nicht an.',
  'sensors.link.ended': 'Die Übung ist zu Ende. Es wird nichts mehr gemessen.',
  'sensors.stored': 'Auf diesem Gerät, noch nicht gesendet: {seconds}',
  'sensors.allSent': 'Was gemessen wurde, ist in Ihrer Praxis gespeichert. Auf diesem Gerät wartet nichts mehr.',
  'sensors.seconds': { one: 'eine Sekunde', other: '{count} Sekunden' },
  'sensors.full':
    'Auf diesem Gerät ist kein Platz mehr. Was nicht sofort gesendet werden kann, geht verloren: Schaffen Sie Platz, oder beenden Sie die Übung.',
  'sensors.lost': {
    one: 'Eine Zehntelsekunde ging verloren.',
    other: '{count} Zehntelsekunden gingen verloren.',
  },
  'sensors.broken':
    'Dieser Browser speichert nichts, deshalb wird nichts gemessen. Verlassen Sie den privaten Modus und versuchen Sie es dann erneut.',
  'sensors.silent': 'Das Telefon misst gerade nicht. Lassen Sie diese Seite im Vordergrund und den Bildschirm an.',
  'sensors.asleep':
    'Der Bildschirm kann hier dunkel werden, und dann wird nichts gemessen. Schalten Sie die automatische Sperre aus, solange Sie üben.',
  'sensors.unsent': 'Noch nicht gesendet',
  'sensors.unsentSending': 'Von einer früheren Übung wird noch etwas an Ihre Praxis gesendet: {seconds}.',
  'sensors.unsentWaiting':
    'Von einer früheren Übung ist auf diesem Gerät noch etwas gespeichert: {seconds}. Es wird gesendet, sobald eine Verbindung besteht.',
  'sensors.unsentRefused':
    'Von einer früheren Übung ist auf diesem Gerät noch etwas gespeichert: {seconds}. Es lässt sich gerade nicht senden. Öffnen Sie diese Seite später noch einmal.',
  'sensors.unsentSent': 'Was auf diesem Gerät gespeichert war, ist an Ihre Praxis gesendet. Es fehlt nichts.',
  'sensors.takenOver': 'Für diese Übung misst jetzt ein anderes Gerät.',
  'sensors.elsewhere': 'Sie messen in einem anderen Fenster',
  'sensors.elsewhereText': 'Machen Sie dort weiter. Wenn Sie es schließen, können Sie hier weitermachen.',
  'sensors.unsentOver':
    'Von einer früheren Übung ist auf diesem Gerät noch etwas gespeichert: {seconds}. Ihre Praxis nimmt es nicht mehr an. Nach vier Wochen wird es gelöscht, oder wenn Sie es hier löschen.',
  'sensors.unsentUnreadable':
    'Von einer früheren Übung ist auf diesem Gerät noch etwas gespeichert, verschlossen mit einem Schlüssel, den der Dienst nicht mehr hat. Es lässt sich nicht mehr senden. Sagen Sie es Ihrer Praxis, und machen Sie die Übung noch einmal.',
  'sensors.unsentDelete': 'Von diesem Gerät löschen',
  'sensors.unsentDeleteTitle': 'Nicht Gesendetes löschen?',
  'sensors.unsentDeleteText':
    'Dieser Teil Ihrer Bewegung ist dann weg. Der Rest, den Ihre Praxis hat, bleibt erhalten.',
  'sensors.fault.unsupported':
    'Dieser Browser kann keine Sensoren verbinden oder lässt Seiten nicht messen. Nehmen Sie auf Android Chrome; auf einem iPhone oder iPad messen Sie mit dem Telefon selbst.',
  'sensors.fault.insecure': 'Zum Messen ist eine sichere Adresse nötig. Öffnen Sie die Adresse, die mit https beginnt.',
  'sensors.fault.denied':
    'Das Telefon durfte nicht messen. Schließen Sie diese Seite, öffnen Sie sie wieder und antworten Sie mit „Erlauben“.',
  'sensors.fault.silent':
    'Dieses Gerät hat keine Bewegungssensoren, oder der Browser gibt sie dieser Seite nicht frei.',
  'sensors.fault.noGyroscope':
    'Dieses Telefon hat kein Gyroskop und kann deshalb keiner Bewegung folgen. Nehmen Sie ein anderes Telefon oder die Sensoren Ihrer Praxis.',
  'sensors.fault.noAccelerometer':
    'Dieses Telefon meldet nicht, wo unten ist. Nehmen Sie ein anderes Telefon oder die Sensoren Ihrer Praxis.',
  'sensors.fault.tooSlow':
    'Dieses Telefon misst zu selten, um einer Bewegung zu folgen. Schalten Sie den Energiesparmodus aus und versuchen Sie es dann erneut.',
  'sensors.fault.notChosen': 'Es wurde kein Sensor gewählt. Ist er geladen und eingeschaltet? Versuchen Sie es erneut.',
  'sensors.fault.notOurs': 'Diesen Sensor können wir nicht lesen. Wählen Sie einen anderen.',
  'sensors.fault.radioOff':
    'Bluetooth ist ausgeschaltet oder nicht erlaubt. Schalten Sie es ein, erlauben Sie es für diese Seite und versuchen Sie es dann erneut.',
  'sensors.fault.cut':
    'Dieses Gerät nimmt nur einen Teil dessen an, was der Sensor sendet, und ist deshalb nicht verwendbar. Versuchen Sie es mit einem anderen Telefon, oder nehmen Sie das Gerät Ihrer Praxis.',
  'sensors.fault.otherWindow':
    'In einem anderen Fenster oder Tab wird schon gemessen. Machen Sie dort weiter, oder schließen Sie es und versuchen Sie es hier erneut.',
  'sensors.fault.failed':
    'Das hat nicht geklappt. Schalten Sie den Sensor aus und wieder ein und versuchen Sie es dann erneut.',
};
