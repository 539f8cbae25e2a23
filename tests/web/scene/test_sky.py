"""A gradient behind everything: dusk, or day."""

import numpy as np
import pytest
import viser

from walking_console.web.scene.sky import DAY, DUSK, Sky, gradient, hang


@pytest.mark.parametrize("sky", [DUSK, DAY])
def test_the_sky_is_lightest_at_the_horizon(sky: Sky) -> None:
    light = gradient(sky).sum(axis=2)[:, 0]
    assert 0.38 < int(np.argmax(light)) / len(light) < 0.46
    assert gradient(sky)[0, 0] == pytest.approx(np.array(sky.top) * 255, abs=1)


def test_by_day_all_of_it_is_lighter_and_so_is_the_fog() -> None:
    assert (gradient(DAY) > gradient(DUSK)).all() and min(DAY.fog) > max(DUSK.fog)


def test_it_is_hung_with_its_fog(
    server: viser.ViserServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    hung: list[object] = []
    monkeypatch.setattr(server.scene, "configure_fog", lambda *_, color: hung.append(color))
    monkeypatch.setattr(
        server.scene, "set_background_image", lambda image, format: hung.append(image)
    )
    hang(server.scene, DAY)
    assert hung[0] == DAY.fog and np.array_equal(hung[1], gradient(DAY))  # type: ignore[arg-type]
