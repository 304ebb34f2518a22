"""A real browser for tests of pages: Chromium without a window, and what it says about a page."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from playwright.sync_api import Browser, ConsoleMessage, Page, Request, sync_playwright

NAMES = ("chromium", "chromium-browser", "google-chrome")
#: No sandbox (tests may run as root), pictures in space drawn by the processor, nothing asked of a network.
ARGUMENTS = (
    "--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip
LAPTOP = {"width": 1366, "height": 768}
PATIENCE_MS = 120_000


def chromium() -> str:
    """Path of the browser.

    A machine without one fails, so that nothing looks green that was not looked at; OWT_NO_BROWSER=1 skips.
    """
    if os.environ.get("OWT_NO_BROWSER"):
        pytest.skip("OWT_NO_BROWSER is set: no page was looked at in a browser")
    found = os.environ.get("OWT_CHROMIUM") or next((p for p in map(shutil.which, NAMES) if p), None)
    if found is None:
        pytest.fail(
            "no Chromium found. Install it (Debian: apt-get install chromium), name it by OWT_CHROMIUM, or "
            "set OWT_NO_BROWSER=1 to skip the tests of pages.",
            pytrace=False,
        )
    return found


@contextmanager
def browser(*more: str, beside: Browser | None = None) -> Iterator[Browser]:
    """Start the browser with `more` arguments; a second one needs the first, `beside` which it runs."""
    path = chromium()
    with ExitStack() as stack:
        kind = beside.browser_type if beside else stack.enter_context(sync_playwright()).chromium
        started = kind.launch(executable_path=path, args=[*ARGUMENTS, *more], timeout=PATIENCE_MS)
        stack.callback(started.close)
        yield started


@dataclass
class Opened:
    """A page, what went wrong on it, and what it asked for besides itself."""

    page: Page
    errors: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def close(self) -> None:
        self.page.context.close()


def open_page(started: Browser, path: Path) -> Opened:
    """Open a page on a laptop's screen and wait until its script is done."""
    context = started.new_context(viewport=LAPTOP, accept_downloads=True)
    context.set_default_timeout(PATIENCE_MS)
    opened = Opened(context.new_page())
    page, own = opened.page, path.absolute().as_uri()

    def asked(request: Request) -> None:
        if request.url != own and not request.url.startswith(("data:", "blob:")):
            opened.requests.append(request.url)

    def said(message: ConsoleMessage) -> None:
        if message.type == "error":
            opened.errors.append(message.text)

    page.on("request", asked)
    page.on("console", said)
    page.on("pageerror", lambda error: opened.errors.append(str(error)))
    page.goto(own, timeout=PATIENCE_MS)
    return opened
