"""A run's log in other forms."""

import json

import numpy as np
import pytest

from tests.server.command_line import called


@pytest.mark.parametrize("form", ["csv", "npz", "mcap"])
def test_a_log_is_written_in_another_form(run_directory, tmp_path, form):
    out = tmp_path / f"log.{form}"
    result = called("export", run_directory, "--to", form, "--out", out)
    assert result.exit_code == 0, result.output
    if form == "csv":
        lines = out.read_text().splitlines()
        assert len(lines) == 201
        assert lines[0].startswith("t_s,x_m,y_m,z_m,roll_rad")
    elif form == "npz":
        with np.load(out, allow_pickle=False) as file:
            assert file["body"].shape == (200, 6) and file["terrain_heights"].ndim == 2
    else:
        from mcap.reader import make_reader

        with out.open("rb") as stream:
            ticks = [
                json.loads(message.data)
                for _, channel, message in make_reader(stream).iter_messages()
                if channel.topic == "/tick"
            ]
        assert len(ticks) == 200 and ticks[-1]["t"] == pytest.approx(4.0)


def test_a_run_is_written_as_one_page_that_needs_no_other_file(run_directory, tmp_path):
    out = tmp_path / "replay.html"
    assert called("export", run_directory, "--to", "html", "--out", out).exit_code == 0
    page = out.read_text("utf-8")
    assert "__VISER_EMBED_DATA__" in page
    assert len(page) > 800_000


def test_an_unknown_form_and_a_missing_run_are_refused(run_directory, tmp_path):
    result = called("export", run_directory, "--to", "pdf")
    assert result.exit_code == 2 and "there are: csv, npz, html, mcap" in result.stderr
    result = called("replay", tmp_path)
    assert result.exit_code == 2 and "no run.json" in result.stderr
