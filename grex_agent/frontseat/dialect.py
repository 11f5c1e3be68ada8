"""MAVLink's messages and their bytes. The only module aboard that knows pymavlink.

A `Codec` is what one pair of ids says and hears: it numbers and signs what goes out, and reads what comes from each
peer by itself, because bytes of two peers do not follow each other.
"""

from typing import Any

from pymavlink.dialects.v20 import ardupilotmega

from grex_link.units import NS

#: The messages, enumerations and constants.
mavlink: Any = ardupilotmega

#: Any message of the dialect; pymavlink has no types.
Mavlink = Any

#: Signing time counts tens of microseconds since 2015.
_SIGNING_EPOCH_S = 1_420_070_400
#: A telemetry radio reports on itself, unsigned.
_UNSIGNED = frozenset({mavlink.MAVLINK_MSG_ID_RADIO_STATUS})


class Codec:
    """Bytes to messages and back, for one link.

    Parameters
    ----------
    own_system, own_component : int
        Who we are.
    key : bytes or None
        Key of 32 bytes: what goes out is signed, and only what is signed with it is heard.
    unix_ns : int
        Wall time, for the signatures.

    Attributes
    ----------
    garbage : int
        Pieces so far that were no message, or not signed with the key.
    """

    def __init__(self, own_system: int, own_component: int, key: bytes | None = None, unix_ns: int = 0) -> None:
        self._key = key
        self._timestamp = max(0, unix_ns // NS - _SIGNING_EPOCH_S) * 100_000
        self._out = self._mav(own_system, own_component)
        self._in: dict[Any, Any] = {}
        self.garbage = 0

    def encode(self, message: Mavlink) -> bytes:
        """Bytes of a message, numbered in turn."""
        data: bytes = message.pack(self._out)
        self._out.seq = (self._out.seq + 1) % 256
        return data

    def decode(self, data: bytes, peer: object = None) -> list[Mavlink]:
        """Messages that are complete with these bytes of a peer."""
        reader = self._in.get(peer)
        if reader is None:
            reader = self._in[peer] = self._mav(0, 0)
        messages = reader.parse_buffer(data) or []
        good = [message for message in messages if message.get_type() != "BAD_DATA"]
        self.garbage += len(messages) - len(good)
        return good

    def forget(self, peer: object) -> None:
        """Forget the half message a peer has left."""
        self._in.pop(peer, None)

    def _mav(self, system: int, component: int) -> Any:
        mav = mavlink.MAVLink(None, srcSystem=system, srcComponent=component)
        mav.robust_parsing = True
        if self._key is not None:
            mav.signing.secret_key = self._key
            mav.signing.sign_outgoing = True
            mav.signing.timestamp = self._timestamp
            mav.signing.allow_unsigned_callback = lambda _, message_id: message_id in _UNSIGNED
        return mav
