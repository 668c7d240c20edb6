// Words of accounts and of what is held about a patient.
import type { Translated } from '../..';
import type { clinic as english } from '../../en/staff/clinic';

export const clinic: Translated<typeof english> = {
  'clinic.title': 'Praxis',
  'clinic.accounts': 'Konten',
  'clinic.add': 'Konto anlegen',
  'clinic.make': 'Anlegen',
  'clinic.role': 'Rolle',
  'clinic.role.administrator': 'Verwaltet Konten und Akten; sieht alles in der Praxis.',
  'clinic.role.therapist':
    'Behandelt; sieht die Personen, die sie selbst angelegt hat oder die für sie freigegeben wurden.',
  'clinic.role.patient': 'Sieht nur die eigene Akte, übt zu Hause.',
  'clinic.role.integrator': 'Verbindet andere Programme; sieht niemanden, der nicht freigegeben wurde.',
  'clinic.record': 'Akte',
  'clinic.recordHelp': 'Die Person, der dieses Konto gehört.',
  'clinic.name': 'Name',
  'clinic.firstPassword': 'Erstes Passwort',
  'clinic.newPassword': 'Neues Passwort',
  'clinic.passwordHelp': 'Mindestens {least} Zeichen; kein gebräuchliches, nicht Ihr Name.',
  'clinic.resetNamed': 'Neues Passwort für {name}',
  'clinic.resetText':
    'Geben Sie dieses Passwort auf sicherem Weg weiter an: {name}. Das Konto wird überall abgemeldet, und das Passwort muss bei der Anmeldung geändert werden.',
  'clinic.active': 'Darf sich anmelden',
  'clinic.inactive': 'Abgeschaltet',
  'clinic.mayS': '{name} darf sich anmelden',
  'clinic.removeSecond': 'Anmeldung in zwei Schritten ausschalten',
  'clinic.removeSecondNamed': 'Anmeldung in zwei Schritten ausschalten: {name}',
  'clinic.removeSecondTitle': 'Anmeldung in zwei Schritten ausschalten: {name}?',
  'clinic.removeSecondText':
    'Für jemanden, der das Gerät und die Ersatzcodes verloren hat. Vergewissern Sie sich, dass wirklich diese Person fragt. Sie wird überall abgemeldet, meldet sich nur mit dem Passwort an und sieht, dass Sie das getan haben.',
  'clinic.hasSecond': 'Anmeldung in zwei Schritten',
  'clinic.settings': 'Zeitzone',
  'clinic.zone': 'Zeitzone der Praxis',
  'clinic.zoneHelp': 'Die Übungswoche beginnt dort am Montag um Mitternacht.',
  'clinic.zoneNotSet': 'Noch nicht gewählt: Es gilt die Einstellung des Dienstes.',
  'clinic.zoneSaved': 'Gespeichert. Die Übungswoche richtet sich jetzt nach dieser Zeitzone.',
  'clinic.devices': 'Geräteschlüssel von Sensorboxen gehören zu einer Person und stehen auf deren Seite.',

  'account.title': 'Mein Konto',
  'account.password': 'Passwort ändern',
  'account.present': 'Aktuelles Passwort',
  'account.change': 'Passwort ändern',
  'account.mustPassword': 'Ihr erstes Passwort kam von jemand anderem. Wählen Sie ein eigenes, um fortzufahren.',
  'account.mustSecond': 'Ihre Praxis verlangt die Anmeldung in zwei Schritten. Richten Sie sie ein, um fortzufahren.',
  'second.title': 'Anmeldung in zwei Schritten',
  'second.what':
    'Außer dem Passwort wird ein Code aus einer App auf Ihrem Telefon verlangt. Ein gestohlenes Passwort allein öffnet dann nichts. Sie brauchen eine Authenticator-App.',
  'second.setUp': 'Einrichten',
  'second.scan':
    'Öffnen Sie die Authenticator-App und lesen Sie dieses Bild ein. Tippen Sie dann die sechs Ziffern ein, die die App zeigt.',
  'second.qr': 'QR-Code für die Authenticator-App',
  'second.byHand': 'Keine Kamera? Tippen Sie diesen Schlüssel in die App:',
  'second.code': 'Code aus der App',
  'second.codeHelp': 'Sechs Ziffern. Telefon verloren? Tippen Sie einen Ihrer Ersatzcodes ein.',
  'second.turnOn': 'Einschalten',
  'second.isOnNow': 'Die Anmeldung in zwei Schritten ist eingeschaltet.',
  'second.keep':
    'Drucken Sie diese Ersatzcodes aus oder schreiben Sie sie auf, und bewahren Sie sie sicher auf. Jeder öffnet Ihr Konto einmal, wenn das Telefon verloren ist. Sie werden nicht noch einmal angezeigt.',
  'second.isOn': 'Eingeschaltet seit {date}.',
  'second.set':
    'Die Anmeldung in zwei Schritten wurde für Ihr Konto am {date} eingeschaltet. Wenn Sie das nicht waren, sagen Sie es der Praxis und ändern Sie Ihr Passwort.',
  'second.removed':
    'Die Verwaltung Ihrer Praxis hat die Anmeldung in zwei Schritten für Ihr Konto am {date} ausgeschaltet. Wenn Sie nicht darum gebeten haben, sagen Sie es der Praxis und ändern Sie Ihr Passwort.',
  'second.setUpAgain': 'Wieder einrichten',
  'second.understood': 'Verstanden',
  'second.left': { one: 'Ein Ersatzcode ist übrig.', other: '{count} Ersatzcodes sind übrig.' },
  'second.turnOff': 'Ausschalten',
  'account.changed': 'Passwort geändert. Alle anderen Browser wurden abgemeldet.',
  'account.goOn': 'Weiter',

  'data.title': 'Daten',
  'data.export': 'Alles herunterladen',
  'data.exportMaking':
    'Die Datei wird erstellt und heruntergeladen: bisher {size}. Bleiben Sie auf dieser Seite; es kann einige Minuten dauern.',
  'data.exportReady': 'Fertig: {size}, in Ihren Downloads.',
  'data.exportBroken': 'Das Herunterladen brach ab. Gespeichert ist nichts; versuchen Sie es noch einmal.',
  'data.archive': 'Archivieren',
  'data.archiveTitle': 'Diese Akte archivieren?',
  'data.archiveText':
    'Die Person steht nicht mehr in der Patientenliste, und nichts kann hinzugefügt werden. Alles bleibt lesbar, und das lässt sich rückgängig machen.',
  'data.archivedOn': 'Archiviert am {date}: Es kann nichts hinzugefügt werden.',
  'data.unarchive': 'Aus dem Archiv zurückholen',
  'data.erase': 'Endgültig löschen',
  'data.eraseFirst': 'Vor dem endgültigen Löschen muss die Akte archiviert werden.',
  'data.eraseTitle': '{name} endgültig löschen?',
  'data.eraseText':
    'Die Akte, alle Aufzeichnungen, Ergebnisse, Vergleiche und das Konto dieser Person werden gelöscht. Im Zugriffsprotokoll steht nur, dass es geschehen ist. Das lässt sich nicht rückgängig machen.',
  'data.eraseType': 'Tippen Sie zur Bestätigung den Nachnamen „{name}“ ein',
  'mine.takeAlong': 'Meine Daten herunterladen',
  'mine.takeAlongText':
    'Eine Datei mit allem, was die Praxis über Sie hat: Ihre Akte, Ihre Bewegung und wer sie angesehen hat. Bewahren Sie sie sicher auf.',
};
