"""German sentences of tasks and limits."""

from typing import Final

GERMAN: Final[dict[str, str | dict[str, str]]] = {
    "job.analysis_failed": "Die Auswertung ist fehlgeschlagen. {reason}",
    "job.given_up": "Die Aufgabe wurde mehrmals unterbrochen und wird nicht noch einmal versucht; die"
    " aufgezeichneten Daten sind gespeichert.",
    "job.internal": "Ein innerer Fehler hat diese Aufgabe angehalten und wurde festgehalten. Die aufgezeichneten"
    " Daten sind gespeichert.",
    "job.interrupted": "Unterbrochen; die Aufgabe beginnt von vorn.",
    "job.memory": "Das braucht mehr Speicher als die {limit_bytes:gib.1}, die eine Aufgabe nehmen darf. Teilen"
    " Sie die Aufzeichnung, und laden Sie die Teile hoch.",
    "job.not_found": "Diese Aufgabe wurde nicht gefunden.",
    "job.session_deleted": "Die Sitzung dieser Aufgabe wurde gelöscht.",
    "job.unknown_kind": "Dieser Dienst kann Aufgaben der Art {kind} nicht ausführen.",
    "level.erase": "Löschen",
    "level.manage": "Verwalten",
    "level.read": "Lesen",
    "level.record": "Aufzeichnen",
    "level.status": "Sehen des Zustands",
    "level.treat": "Behandeln",
    "limit.exports": "Warten Sie, bis einer fertig ist, und fragen Sie dann noch einmal.",
    "limit.reached": "{what:limited} ({scope:limit_scope}): höchstens {most} auf einmal. {advice}",
    "limit.sockets": "Schließen Sie eine, und öffnen Sie diese dann noch einmal.",
    "limit.streams": "Beenden Sie eine Sitzung, und verbinden Sie dann noch einmal.",
    "limit.uploads": "Warten Sie, bis eines angekommen ist, und senden Sie dieses dann noch einmal.",
    "limit.views": "Schließen Sie eine, oder versuchen Sie es in einer Minute noch einmal.",
    "limit_scope.account": "je Konto",
    "limit_scope.clinic": "in Ihrer Praxis",
    "limit_scope.service": "in diesem Dienst",
    "limited.exports": "Exporte in Arbeit",
    "limited.sockets": "Offene Live-Ansichten",
    "limited.streams": "Übertragende Gateways",
    "limited.uploads": "Laufendes Hochladen",
    "limited.views": "Offene 3D-Ansichten",
}

__all__ = ["GERMAN"]
