"""Try faults on a served console, all on this computer, and keep what came of it in docs/faults.md.

Run: python -m tests.sweeps.faults [KEY...] --count 100 (without a KEY: every fault; --list says
which there are; --dry changes no file).
"""

from __future__ import annotations

import argparse

from tests.sweeps.faults import desktop, edits, floods, links, pages, table, thumbs
from tests.sweeps.faults.table import Fault

FAULTS: tuple[Fault, ...] = (
    *thumbs.FAULTS,
    *pages.FAULTS,
    *desktop.FAULTS,
    *links.FAULTS,
    *floods.FAULTS,
    *edits.FAULTS,
)


def main() -> None:
    """Try, print and keep."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("keys", nargs="*", choices=[[], *(fault.key for fault in FAULTS)])
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--dry", action="store_true")
    options = parser.parse_args()
    for fault in FAULTS:
        if options.list:
            print(f"{fault.key:16}{fault.title}: {fault.must}")
        elif not options.keys or fault.key in options.keys:
            count = min(options.count, fault.most)
            row = fault.row(fault.trials(count), count)
            print(row, flush=True)
            if not options.dry:
                table.write(FAULTS, {fault.title: row})


if __name__ == "__main__":
    main()
