"""Sets of samples of a trace as integers, one bit a sample.

Intersections, first and last samples are then single operations on integers, and a whole search
costs a few milliseconds. With rows beside the trace, sample ``k`` of row ``r`` is bit
``r * width + k``; the bit after each row stays empty, so that runs never cross rows. Row 0 is the
trace itself.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

BACK_COST = 10  # samples forward that one sample back counts for: larger keeps it going onward
ROW_COST = 5  # samples a row beside the trace counts for: larger keeps it on the trace


def first_bit(mask: int) -> int:
    """Lowest sample in a non-empty mask."""
    return (mask & -mask).bit_length() - 1


def run_end(mask: int, sample: int) -> int:
    """Last sample of the unbroken run of ``mask`` that contains ``sample``."""
    rest = ~(mask >> sample)
    return sample + (rest & -rest).bit_length() - 2


def run_start(mask: int, sample: int) -> int:
    """First sample of the unbroken run of ``mask`` that contains ``sample``."""
    gaps = ~mask & ((1 << sample) - 1)
    return gaps.bit_length()


def _run(mask: int, sample: int) -> int:
    """The unbroken run of ``mask`` that contains ``sample``."""
    ahead = mask >> sample
    end = (~ahead & ahead + 1).bit_length() - 1 + sample
    start = (~mask & (1 << sample) - 1).bit_length()
    return (1 << end) - (1 << start)


def span(first: int, last: int) -> int:
    """A mask of samples first..last; empty when last < first."""
    return ((1 << (last - first + 1)) - 1) << first if last >= first else 0


def bits_of(flags: NDArray[np.bool_]) -> int:
    """Flags (n,) as a mask, the first as bit 0."""
    return int.from_bytes(np.packbits(flags, bitorder="little").tobytes(), "little")


class SampleGrid:
    """How samples of ``rows`` rows of ``count`` are numbered, and the unbroken parts of masks."""

    __slots__ = ("all", "count", "row_mask", "rows", "width")

    def __init__(self, rows: int, count: int) -> None:
        self.rows = rows
        self.count = count
        self.width = count + 1
        self.row_mask = (1 << self.width) - 1
        self.all = self.in_all_rows((1 << count) - 1)

    def in_all_rows(self, row: int) -> int:
        """The same samples in every row."""
        mask = 0
        for r in range(self.rows):
            mask |= row << (r * self.width)
        return mask

    def row_of(self, mask: int, row: int) -> int:
        """The samples of one row, numbered from its own first."""
        return mask >> (row * self.width) & self.row_mask

    def pack(self, flags: NDArray[np.bool_]) -> int:
        """Flags (rows, count) as a mask."""
        return bits_of(np.pad(flags, ((0, 0), (0, 1))).ravel())

    def pack_each(self, flags: NDArray[np.bool_]) -> list[int]:
        """Flags (n, rows, count) as n masks."""
        padded = np.pad(flags, ((0, 0), (0, 0), (0, 1))).reshape(len(flags), -1)
        packed = np.packbits(padded, axis=1, bitorder="little")
        return [int.from_bytes(bits.tobytes(), "little") for bits in packed]

    def unbroken(self, mask: int, sample: int) -> int:
        """The unbroken part of ``mask`` that contains ``sample``: runs along rows, joined where two
        rows have a sample in common.

        The body may go straight from one row to another at the same sample: what holds at both ends
        does so between.
        """
        run = _run(mask, sample)
        if self.rows == 1 or run == mask:
            return run
        found = run
        fresh = run
        width = self.width
        while fresh:
            beside = 0
            for shift in range(width, self.rows * width, width):
                beside |= fresh << shift | fresh >> shift
            beside &= mask & ~found
            fresh = 0
            while beside:
                run = _run(mask, (beside & -beside).bit_length() - 1)
                fresh |= run
                beside &= ~run
            found |= fresh
        return found

    def farthest(self, part: int) -> int:
        """The last sample of the trace a part reaches, in any row."""
        if self.rows == 1:
            return part.bit_length() - 1
        most = -1
        while part:
            most = max(most, (part & self.row_mask).bit_length() - 1)
            part >>= self.width
        return most

    def nearest(self, part: int, sample: int) -> int:
        """Where in a part to be, coming from ``sample``: onward rather than back, near rather than
        far, near the trace.
        """
        if self.rows == 1:
            ahead = part >> sample
            return sample + first_bit(ahead) if ahead else part.bit_length() - 1
        k = sample % self.width
        best = -1
        least = math.inf
        for r in range(self.rows):
            row = self.row_of(part, r)
            if row:
                ahead = row >> k
                at = k + first_bit(ahead) if ahead else row.bit_length() - 1
                cost = at - k if at >= k else BACK_COST * (k - at)
                cost += ROW_COST * ((r + 1) // 2)
                if cost < least:
                    best = r * self.width + at
                    least = cost
        return best

    def way(self, mask: int, start: int, end: int) -> list[int]:
        """Samples the body passes from start to end inside the mask: along a row, and across rows
        where it must. Raises ``RuntimeError`` when no way leads there.
        """
        if start == end:
            return [start]
        if start // self.width == end // self.width:
            onward = 1 if end > start else -1
            between = list(range(start, end + onward, onward))
            if all(mask >> sample & 1 for sample in between):
                return between
        came = self._flooded(mask, start, end)
        if end not in came:
            raise RuntimeError(
                f"no way for the body from sample {start} to {end}: the states do not overlap"
            )
        way = [end]
        while way[-1] != start:
            way.append(came[way[-1]])
        return way[::-1]

    def _flooded(self, mask: int, start: int, end: int) -> dict[int, int]:
        """The sample each sample around ``start`` is reached from, until ``end`` is."""
        came = {start: start}
        edge = [start]
        across = [r * self.width for r in range(1 - self.rows, self.rows) if r]
        while edge and end not in came:
            reached = []
            for sample in edge:
                for other in (sample + 1, sample - 1, *(sample + shift for shift in across)):
                    if other >= 0 and other not in came and mask >> other & 1:
                        came[other] = sample
                        reached.append(other)
            edge = reached
        return came
