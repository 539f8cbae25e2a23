"""One file of every kind people bring: the heights it holds are walked on, with nothing but its
name or with the one key it names.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.sweeps.height_files import CELL, FILES, HILL, HeightFile, asked, table, walked

PAGE = Path(__file__).parents[3] / "docs" / "height-files.md"
OTHERWISE = {  # files whose heights are not those of a grid as it is in the file
    "unequal.tif": (100, 120),
    "degrees.tif": (1000, 1000),
}


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_a_file_of_every_kind_is_walked_on_as_it_is(file: HeightFile, tmp_path: Path) -> None:
    answer = asked(file, tmp_path)
    assert answer.ground is not None, answer.said
    ground = answer.ground
    if file.name in OTHERWISE:
        assert ground.heights.shape == OTHERWISE[file.name]
    elif file.heights.shape == ground.heights.shape:
        assert ground.cell == pytest.approx(file.cell)
        start = HILL[50, 60] if file.name == "sea.tif" else 0.0
        np.testing.assert_allclose(ground.heights + start, file.heights, atol=6e-5)
    else:  # a mesh, in cells of at most 0.025 m
        assert ground.cell == CELL / 2
        np.testing.assert_allclose(ground.heights[::2, ::2] + 0.03 * CELL / 4, file.heights)
    assert walked(file, answer.key, tmp_path) == 0


def test_at_most_one_file_in_ten_needs_a_key_and_the_page_holds_the_table(tmp_path: Path) -> None:
    made = table(tmp_path)
    assert made in PAGE.read_text("utf-8"), (
        "run python -m tests.sweeps.height_files FOLDER and put what it prints into the page"
    )
    alone, _, count = made.rsplit("\n\n", 1)[1].split(" load", 1)[0].split(" ")
    assert int(count) == len(FILES) and int(alone) >= 0.9 * len(FILES)
