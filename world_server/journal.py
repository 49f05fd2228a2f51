"""The journal: an append-only file of records, compressed as one stream and chained by a hash.

Each record stands behind its length and its seal, and is flushed before the next grant, so that a reader
finds everything up to the last commit even when the writer was killed. A seal is the hash of the chain's
value and the record. The chain covers commits only, whose seals are its values; it begins
with the seed and the names of the nodes, and its last value is the run's hash.
"""

import hashlib
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import msgspec
import numpy as np
import zstandard

from wire import codec
from wire.messages import Frame, Percept
from wire.scenario import Scenario
from world_server.records import Commit, End, Grant, Header

_FRAME = struct.Struct("<BI16s")  # kind, length, seal
_KINDS = (Header, Commit, End)
_COMMIT = 1
_CHUNK = 1 << 20


class JournalError(Exception):
    """A journal that is not one, or whose chain is broken; the text names the file and what is wrong."""


class Journal:
    """The writing side. `stream` is a binary file opened for appending; None: there is only the chain."""

    def __init__(
        self, stream: BinaryIO | None, scenario: Scenario, scenario_toml: str, first_poses: bytes
    ) -> None:
        self._stream = stream
        self._compressor = zstandard.ZstdCompressor(level=1).compressobj()
        self._chain = _origin(scenario.seed, scenario.node_ids)
        self._write(0, codec.encode(Header(scenario.seed, scenario_toml, scenario.node_ids, first_poses)))

    @property
    def run_hash(self) -> str:
        """The chain's value now: equal for equal runs up to here."""
        return self._chain.hex()

    def append(self, commit: Commit) -> None:
        """Chain and write one commit."""
        data = codec.encode(commit)
        self._chain = _link(self._chain, data)
        self._write(_COMMIT, data)

    def close(self, tick: int, completed: bool) -> None:
        """Write the end."""
        self._write(2, codec.encode(End(tick, completed, self.run_hash)))
        if self._stream is None:
            return
        self._stream.write(self._compressor.flush())
        self._stream.flush()

    def _write(self, kind: int, data: bytes) -> None:
        if self._stream is None:
            return
        seal = self._chain if kind == _COMMIT else _link(self._chain, data)
        record = _FRAME.pack(kind, len(data), seal) + data
        compressed = self._compressor.compress(record)
        self._stream.write(compressed + self._compressor.flush(zstandard.COMPRESSOBJ_FLUSH_BLOCK))
        self._stream.flush()


def read(path: Path) -> Iterator[Header | Commit | End]:
    """All whole records of a journal, which may be growing or cut off. Raises JournalError."""
    chain = b""
    for kind, expected, data in _records(path):
        try:
            record = codec.decode(_KINDS[kind], data, at_most=len(data))
        except (codec.Malformed, IndexError) as error:
            raise JournalError(f"{path}: not a journal that this program can read: {error}") from None
        if kind == 0:
            chain = _origin(record.seed, record.nodes)
        seal = _link(chain, data)
        chain = seal if kind == _COMMIT else chain
        if seal != expected:
            raise JournalError(f"{path}: the hash chain is broken at tick {getattr(record, 'tick', 0)}")
        yield record


def commits(path: Path) -> Iterator[Commit]:
    """The commits of a journal."""
    return (record for record in read(path) if isinstance(record, Commit))


def memories(path: Path, node: str) -> bytes:
    """All that a node was ever told since its memory last began, for a mind to live through again."""
    told: list[bytes] = []
    on_the_way: dict[tuple[str, int, int], bytes] = {}
    records = read(path)
    names = next(records).nodes
    row = names.index(node)
    for commit in (record for record in records if isinstance(record, Commit)):
        if any(fault.node == node and fault.verb == "kill" for fault in commit.facts.faults):
            on_the_way.clear()
        for grant in commit.grants:
            if grant.node == node:
                told = [] if grant.configuration else told
                told.append(codec.encode(_percept(commit.tick, grant, on_the_way)))
        on_the_way |= _delivered(commit, names, row)
    return msgspec.msgpack.encode(told)


def _delivered(commit: Commit, names: tuple[str, ...], row: int) -> dict[tuple[str, int, int], bytes]:
    """Payloads that got through to the node in `row`, by sender, tick and place in the outbox."""
    said = {grant.node: action.outbox for grant, action in zip(commit.grants, commit.actions, strict=True)}
    senders, frames, receivers = (np.frombuffer(column, "<u2") for column in commit.deliveries[:3])
    own = receivers == row
    pairs = zip(senders[own].tolist(), frames[own].tolist(), strict=True)
    return {(names[sender], commit.tick, index): said[names[sender]][index] for sender, index in pairs}


def _percept(tick: int, grant: Grant, on_the_way: dict[tuple[str, int, int], bytes]) -> Percept:
    inbox = tuple(
        Frame(one.sender, one.sent_tick, on_the_way.pop((one.sender, one.sent_tick, one.index)))
        for one in grant.inbox
    )
    return Percept(tick, grant.grant, grant.why, grant.senses, inbox, grant.configuration)


def _origin(seed: int, nodes: tuple[str, ...]) -> bytes:
    return hashlib.blake2b(codec.encode((seed, nodes)), digest_size=16).digest()


def _link(chain: bytes, data: bytes) -> bytes:
    return hashlib.blake2b(chain + data, digest_size=16).digest()


def _records(path: Path) -> Iterator[tuple[int, bytes, bytes]]:
    """Kind, seal and bytes of every whole record; what follows the last whole one is ignored."""
    buffer = bytearray()
    with path.open("rb") as stream:
        expander = zstandard.ZstdDecompressor().decompressobj()
        while chunk := stream.read(_CHUNK):
            try:
                buffer += expander.decompress(chunk)
            except zstandard.ZstdError as error:
                raise JournalError(f"{path}: not a journal: {error}") from None
            start = 0
            while start + _FRAME.size <= len(buffer):
                kind, length, seal = _FRAME.unpack_from(buffer, start)
                end = start + _FRAME.size + length
                if end > len(buffer):
                    break
                yield kind, seal, bytes(buffer[start + _FRAME.size : end])
                start = end
            del buffer[:start]
