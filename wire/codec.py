"""MessagePack with a schema version in front, validated on the way in.

The first byte of every message is the schema version; what follows is one array-like Struct. Whatever is
wrong with received bytes, the answer is one exception, `Malformed`, whose text says what and where.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import msgspec

SCHEMA_VERSION = 1
MAX_BYTES = 8 * 1024 * 1024

_PREFIX = bytes([SCHEMA_VERSION])
_encoder = msgspec.msgpack.Encoder()


class Malformed(ValueError):
    """Received bytes that are not a valid message."""


def encode(message: Any) -> bytes:
    """One message as bytes; equal messages give equal bytes."""
    return _PREFIX + _encoder.encode(message)


def decode(kind: Any, data: bytes, at_most: int = MAX_BYTES) -> Any:
    """The message of type `kind` in `data`. Raises Malformed."""
    return decoder(kind, at_most)(data)


@cache
def decoder(kind: Any, at_most: int = MAX_BYTES) -> Callable[[bytes], Any]:
    """`decode` for messages of one type: for who decodes many and need not look the type up each time."""
    decode_body = msgspec.msgpack.Decoder(kind).decode

    def decode_one(data: bytes) -> Any:
        if not data:
            raise Malformed("no bytes at all")
        if data[0] != SCHEMA_VERSION:
            raise Malformed(f"schema version {data[0]}, this program speaks {SCHEMA_VERSION}")
        if len(data) > at_most:
            raise Malformed(f"{len(data)} bytes, at most {at_most} are read")
        try:
            return decode_body(memoryview(data)[1:])
        except (msgspec.DecodeError, ValueError, RecursionError) as error:
            raise Malformed(str(error)) from None

    return decode_one
