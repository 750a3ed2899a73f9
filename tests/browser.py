"""A real browser for tests: Debian's Chromium, headless, with WebGL in software."""

import io
import os
import shutil
from contextlib import contextmanager

import numpy as np
import pytest
from PIL import Image

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
FLAGS = [
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
SIZE = {"width": 900, "height": 700}


def require_browser():
    """Skip the test where there is no browser; in CI, which installs one, that is a failure."""
    try:
        import playwright.sync_api  # noqa: F401
    except ImportError:
        missing = "playwright is not installed"
    else:
        if CHROMIUM is not None:
            return
        missing = "no Chromium on the path"
    (pytest.fail if os.environ.get("CI") else pytest.skip)(f"{missing}: the replay cannot be looked at")


class Page:
    """An open page, with everything that it complained of or asked for."""

    def __init__(self, page):
        self.page = page
        self.complaints, self.requests = [], []
        page.on("console", lambda message: message.type == "error" and self.complaints.append(message.text))
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on("request", lambda request: self.requests.append(request.url))

    def open(self, address):
        self.page.goto(address)
        self.page.wait_for_selector("body[data-ready]", state="attached", timeout=60_000)
        self.page.add_style_tag(content="#labels, .dg { display: none; }")

    def run(self, script, argument=None):
        return self.page.evaluate(script, argument)

    def seek(self, time):
        self.run("(time) => { viewer.animator.pause(); seek(time); viewer.render(); }", time)

    def show(self, path, visible):
        """Show or hide a part of the scene; of a robot's path, `robot` is the arm."""
        self.run(
            "([path, visible]) => { viewer.scene_tree.find(path.split('/')).object.visible = visible; "
            "viewer.render(); }",
            [path, visible],
        )

    def picture(self):
        """The canvas as an array of pixels, shape (height, width, 3)."""
        self.run("() => new Promise((done) => requestAnimationFrame(() => { viewer.render(); done(); }))")
        return np.asarray(Image.open(io.BytesIO(self.page.locator("canvas").first.screenshot())).convert("RGB")).astype(
            int
        )

    def pixel(self, point):
        """Where a point of the world, shape (3,), m, is in `picture`: column and row."""
        scene, view, projection = (
            np.array(self.run(f"() => viewer.{name}.elements")).reshape(4, 4).T
            for name in ("scene.matrixWorld", "camera.matrixWorldInverse", "camera.projectionMatrix")
        )
        x, y, _, w = projection @ view @ scene @ [*point, 1.0]
        height, width, _ = self.picture().shape
        return np.array([0.5 * width * (1.0 + x / w), 0.5 * height * (1.0 - y / w)])


@contextmanager
def open_browser():
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        try:
            yield lambda: Page(browser.new_page(viewport=SIZE))
        finally:
            browser.close()


def changed(one, other, threshold=12):
    """Which pixels differ between two pictures, shape (height, width)."""
    return np.abs(one - other).max(axis=2) > threshold
