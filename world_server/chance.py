"""Chance as a function: a generator for a purpose, a node and a tick, the same whoever asks and when."""

import zlib

import numpy as np


def generator(seed: int, purpose: str, *key: int) -> np.random.Generator:
    """A counter-based generator keyed by seed, purpose and numbers (a node, a tick)."""
    return np.random.Generator(np.random.Philox(np.random.SeedSequence(key_of(seed, purpose, *key))))


def key_of(seed: int, purpose: str, *key: int) -> tuple[int, ...]:
    """The key of such a generator, for a process that must draw by itself."""
    return (seed, zlib.crc32(purpose.encode()), *key)
