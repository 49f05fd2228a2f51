"""What every message is made of."""

from typing import Annotated

import msgspec

NodeId = Annotated[str, msgspec.Meta(pattern=r"^[a-z][a-z_]{0,15}[0-9]{1,4}\Z")]
Count = Annotated[int, msgspec.Meta(ge=0, le=2**53)]


class Message(msgspec.Struct, array_like=True, frozen=True, forbid_unknown_fields=True):
    """Base of all that is said: immutable, compact, strict about its fields."""
