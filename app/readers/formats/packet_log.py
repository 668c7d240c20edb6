"""Our packet log: the hello and every packet as it came."""

from io import BytesIO
from typing import TYPE_CHECKING

from app.readers.contract import Reader, Source

if TYPE_CHECKING:
    from estimators.recording import Recording


class PacketLogReader(Reader):
    """The log of a gateway, or the one that a session is downloaded as."""

    title = "Packet log of a sensor box"
    description = "As downloaded from a session, or stored by a sensor box (.tmlog)"
    endings = frozenset({".tmlog"})
    asks_pipeline = True
    holds_packets = True

    def recognises(self, source: Source) -> bool:
        """By its first bytes."""
        return source.start.startswith(b"TML1")

    def read(self, source: Source) -> "Recording":
        """Read it on the common tick of its session, or on the stamps of its file."""
        from app.readers.log import read_packet_log

        return read_packet_log(source.path)

    def announces(self, source: Source) -> tuple[tuple[str, ...], float]:
        """Return what its hello says."""
        from app.network.packet_log import read_head
        from app.readers.log import declaration_of

        declared = declaration_of(read_head(BytesIO(source.start)))
        return declared.placements, declared.rate_hz
