"""Whether a JSON text is one that its reader can bear: not deep, no number of a thousand digits.

Looked at before it is parsed: parsers answer depth with a RecursionError, or not at all.
"""

from __future__ import annotations

import re

import numpy as np

from .limits import JSON_DEPTH_MAX, NUMBER_MAX

STRING = re.compile(rb'"(?:[^"\\]|\\.)*"', re.DOTALL)
LONG_NUMBER = re.compile(rb"[0-9.eE+-]{%d}" % (NUMBER_MAX + 1))
BRACKETS = b"[]{}"
OTHERS = bytes(set(range(256)) - set(BRACKETS))


def fault_of(text: bytes) -> str:
    """What is wrong with the shape of this text, in a sentence; '' where nothing is."""
    outside = STRING.sub(b'""', text)
    if LONG_NUMBER.search(outside):
        return f"a number may have {NUMBER_MAX} characters"
    brackets = np.frombuffer(outside.translate(None, OTHERS), dtype=np.uint8)
    opened = (brackets == ord("[")) | (brackets == ord("{"))
    depth = np.cumsum(np.where(opened, 1, -1))
    if len(depth) and int(depth.max()) > JSON_DEPTH_MAX:
        return f"JSON may be {JSON_DEPTH_MAX} brackets deep"
    return ""
