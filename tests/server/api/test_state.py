"""What the routes share: one text for all pages, and everybody waked at once."""

import asyncio
from pathlib import Path

import pytest

from walking_console.server.api.state import AppSettings, AppState, ChangeSignal
from walking_console.server.realtime_loop import RealtimeLoop


@pytest.fixture
def state(loop: RealtimeLoop, tmp_path: Path) -> AppState:
    return AppState(loop, AppSettings(data=tmp_path), None)


def test_the_newest_snapshot_is_made_into_text_once_for_all_pages(state: AppState) -> None:
    text = state.text()
    assert state.text() is text
    state.loop.tick()
    assert state.text() is not text


def test_a_stop_and_a_fault_make_another_text(state: AppState) -> None:
    texts = [state.text()]
    state.lease.latch.set(True)
    texts.append(state.text())
    state.loop.fault = "ValueError: no"
    texts.append(state.text())
    assert len(set(texts)) == 3 and '"fault":"ValueError: no"' in texts[2]


def test_a_change_wakes_everybody_who_waits_and_nobody_who_comes_later() -> None:
    async def story() -> tuple[int, bool]:
        signal = ChangeSignal()
        waiting = [asyncio.create_task(signal.wait()) for _ in range(3)]
        await asyncio.sleep(0)
        signal.notify()
        done, _ = await asyncio.wait(waiting, timeout=1.0)
        late = asyncio.create_task(signal.wait())
        await asyncio.sleep(0)
        woken = late.done()
        late.cancel()
        return len(done), woken

    assert asyncio.run(story()) == (3, False)


def test_waiting_for_what_never_comes_ends_at_its_limit(state: AppState) -> None:
    async def story() -> bool:
        async with state.serving():
            state.loop._thread = _Running()  # type: ignore[assignment]
            return await state.until(lambda: False, 0.01)

    assert asyncio.run(story()) is False


class _Running:
    running = True


def test_while_nobody_serves_the_loop_tells_nobody(state: AppState) -> None:
    async def story() -> None:
        async with state.serving():
            assert state.changes is not None
            changed = asyncio.create_task(state.changes.wait())
            await asyncio.sleep(0)
            state.loop.tick()
            await asyncio.wait_for(changed, 1.0)

    asyncio.run(story())
    state.loop.tick()  # the web loop is closed: nothing is raised
    assert state.loop.ticks_run == 2
