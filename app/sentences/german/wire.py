"""German sentences of what gateways say first."""

from typing import Final

GERMAN: Final[dict[str, str | dict[str, str]]] = {
    "hello.too_many": "Zu viele Tickets von dieser Adresse waren ungültig; versuchen Sie es in {seconds:s} erneut.",
    "hello.first": "Die erste Nachricht muss ein JSON-Hello sein.",
    "hello.no_sensor": "Das Hello nennt keinen Sensor; führen Sie die Stellen in der Reihenfolge der Pakete auf.",
    "hello.not_understood": "Das Hello ist nicht gültig: {faults}",
    "hello.placement_twice": "Eine Stelle ist zweimal genannt; jeder Sensor hat seine eigene.",
    "hello.placements_unknown": "Unbekannte Stellen: {unknown:and}; verwenden Sie {known:or}.",
    "hello.protocol_version": "Dieser Dienst spricht Protokollversion {ours}, das Hello {theirs}; aktualisieren"
    " Sie das Gateway.",
    "hello.rate": "Eine Rate von {rate_hz:number~4} Hz ist nicht möglich; senden Sie 10 bis 1000 Hz.",
    "hello.scale": "Der Wert von {field} ist {value}; er muss über 0 und höchstens {limit} in SI-Einheiten sein.",
    "hello.serials": "Das Hello nennt {sensors} Sensoren und {serials} verschiedene Seriennummern; senden Sie"
    " eine je Sensor, oder keine.",
    "hello.timeout": "Senden Sie innerhalb von {seconds:s} nach dem Verbinden ein Hello.",
}

__all__ = ["GERMAN"]
