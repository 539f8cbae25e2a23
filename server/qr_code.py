"""An address as a QR code of text, for the telephone that is to open it."""

from __future__ import annotations

import sys

import segno

QUIET = 2  # modules of margin, enough for cameras
# upper and lower module of a letter, each light or dark; on the usual dark terminal light is drawn
BLOCKS = {(0, 0): "█", (0, 1): "▀", (1, 0): "▄", (1, 1): " "}


def qr_code(text: str) -> list[str]:
    """The lines of its QR code: two rows of modules a line, light modules drawn."""
    rows = [list(row) for row in segno.make(text, error="l", micro=False).matrix_iter(border=QUIET)]
    if len(rows) % 2:
        rows.append([0] * len(rows[0]))
    return [
        "".join(BLOCKS[upper, lower] for upper, lower in zip(*pair, strict=True))
        for pair in zip(rows[::2], rows[1::2], strict=True)
    ]


def print_qr_code(text: str) -> None:
    """Print it, where standard output has letters for it."""
    picture = "\n".join(qr_code(text))
    try:
        picture.encode(sys.stdout.encoding or "ascii")
    except (UnicodeEncodeError, LookupError):
        return
    print(picture, flush=True)
