"""Links that go black for a while, and links that are slow."""

from __future__ import annotations

import time

from playwright.sync_api import Page

from tests.sweeps.faults.console import DEAD_MAN, TICK, Hand, Socket, begin_anew, served
from tests.sweeps.faults.pages import browsing
from tests.sweeps.faults.proxy import Proxy, proxied
from tests.sweeps.faults.table import Fault, Outcome, share, spread
from tests.web.browsing import DRAW_SELDOM, drag_until

SHORT = 0.2  # s
LONG = (0.3, 0.5, 1.0, 2.0, 5.0)  # s
WITHIN = DEAD_MAN + 2 * TICK
SLOW = 60_000.0  # bytes a second
PICTURES = 5.0  # a second
COMMAND_TIME = 0.15  # s
LOOKS = 20  # s


def short(count: int) -> Outcome:
    """Black for 0.2 s: it walks on."""
    stops = 0
    with served() as console, Socket(console.url) as watcher, proxied(console.port) as proxy:
        with Hand(proxy.url) as hand:
            for number in range(count):
                if number % 10 == 0:
                    begin_anew(console.url)
                if number % 10 == 0 or watcher.seen[-1].rests:
                    hand.walk()
                begun = time.monotonic()
                black(proxy, SHORT)
                time.sleep(0.5)
                stops += any(seen.rests for seen in watcher.seen if seen.at > begun)
    return Outcome(f"{stops} of {count} stop", stops == 0)


def black(proxy: Proxy, seconds: float) -> None:
    proxy.stall(True)
    time.sleep(seconds)
    proxy.stall(False)


def long(count: int) -> Outcome:
    """Black for longer, the stick held all the time: it stops, and no old command moves it."""
    taken: list[float | None] = []
    moved = 0
    with served() as console, Socket(console.url) as watcher, proxied(console.port) as proxy:
        for number in range(count):
            with Hand(proxy.url) as hand:
                hand.say({"type": "take"})
                hand.walk()
                begun = time.monotonic()
                black(proxy, LONG[number % len(LONG)])
                if LONG[number % len(LONG)] > DEAD_MAN or stopped_since(watcher, begun):
                    taken.append(watcher.rest_after(begun))
                    moved += not watcher.stays_at_rest(1.0)
            if number % 5 == 4:
                begin_anew(console.url)
    found = spread(taken, WITHIN)
    return Outcome(
        f"{found.measured} to rest; old commands obeyed {moved}", found.held and not moved
    )


def stopped_since(watcher: Socket, begun: float) -> bool:
    time.sleep(0.3)
    return any(seen.rests for seen in watcher.seen if seen.at > begun)


def slow(count: int) -> Outcome:
    """A whole page with its scene shares 60 kB/s; what comes is hardly drawn: without a graphics
    card that takes this computer longer than the link takes.
    """
    with browsing() as (console, watcher, browser), proxied(console.port) as proxy:
        context = browser.new_context(viewport={"width": 900, "height": 620})
        context.add_init_script(DRAW_SELDOM)
        page = context.new_page()
        page.goto(proxy.url + "/?stand")
        page.wait_for_selector("body.live", timeout=60_000)
        page.wait_for_timeout(10_000)  # the scene has come
        page.evaluate("window.aside = true")
        proxy.rate = SLOW
        drag_until(page, 0.0, 1.0, lambda: bool(watcher.newest["walked_m_s"] > 0.0))
        rate = pictures(page, LOOKS)
        answers = [answer(page, watcher, number) for number in range(count)]
        page.mouse.up()
        context.close()
    late = [one for one in answers if one is None]
    told = [one for one in answers if one is not None]
    worst = share(told, 0.99) if told else 0.0
    said = f"{rate:.1f} pictures/s; command to machine p99 {1000 * worst:.0f} ms, {len(late)} lost"
    return Outcome(said, rate >= PICTURES and worst <= COMMAND_TIME and not late)


COUNTED = """seconds => new Promise(done => { let shown = 0;
 const clock = document.querySelector('#time');
 const look = new MutationObserver(() => shown++);
 look.observe(clock, {childList: true, characterData: true, subtree: true});
 setTimeout(() => { look.disconnect(); done(shown / seconds); }, seconds * 1000); })"""


def pictures(page: Page, seconds: float) -> float:
    """How many pictures a second the page shows."""
    return float(page.evaluate(COUNTED, seconds))


def answer(page: Page, watcher: Socket, number: int) -> float | None:
    """Seconds from a move of the stick to the machine's having heard of it."""
    before = watcher.newest["crab_angle_rad"]
    box = page.locator("#stick").bounding_box()
    assert box is not None
    side = 30 if number % 2 else -30
    begun = time.monotonic()
    page.mouse.move(box["x"] + box["width"] / 2 + side, box["y"] + box["height"] / 2 - 30)
    return watcher.seconds_to(lambda seen: seen.frame["crab_angle_rad"] != before, begun)


FAULTS = (
    Fault("black-short", f"link black for {SHORT} s", "no stop", short),
    Fault(
        "black-long",
        "link black for 0.3, 0.5, 1, 2 or 5 s, stick held",
        f"at rest within {WITHIN:.2f} s where it stops, and no old command is obeyed",
        long,
    ),
    Fault(
        "slow-link",
        "page with its scene on a link of 60 kB/s",
        f"≥ {PICTURES:.0f} pictures a second, commands p99 ≤ {1000 * COMMAND_TIME:.0f} ms",
        slow,
    ),
)
