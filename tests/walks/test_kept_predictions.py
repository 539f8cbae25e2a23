"""K requirement 3: what was predicted is walked; nothing is worked out again that still holds."""

from __future__ import annotations

import pytest

from tests.sweeps.seams import walk


@pytest.mark.parametrize("fraction", [0.10, 0.04])
@pytest.mark.parametrize("seed", [0, 1])
def test_five_predictions_lead_along_the_curve_and_the_body_never_halts(
    fraction: float, seed: int
) -> None:
    told = walk("k-curve", f"terrain.fraction={fraction}", f"seed={seed}")
    assert (told.ending[0], told.predictions, told.halts) == ("completed", 5, 0)
