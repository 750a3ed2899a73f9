"""The page of a replay: meshcat's viewer, the scene and what is shown beside it, in one HTML file."""

from __future__ import annotations

import base64
import gzip
import html
import json
import re
from collections.abc import Sequence
from functools import cache
from importlib import resources
from typing import Any

SCRIPTS = ("scene.js", "run_view.js", "page.js")
"""What the page runs, in this order, as one script."""


def build_page(title: str, commands: Sequence[bytes], data: dict[str, Any]) -> str:
    """Return a page that needs nothing but a browser: no network, no other file.

    Args:
        title: Title of the page.
        commands: Packed drawing commands of meshcat, in order.
        data: What the scripts show beside them; see `replay_scene` and `readings.run_data`.
    """
    packed = base64.b64encode(gzip.compress(b"".join(commands), mtime=0)).decode()
    parts = {
        "title": html.escape(title),
        "style": _part("page.css"),
        "data": _embedded({**data, "lengths": [len(command) for command in commands]}),
        "commands": packed,
        "script": "\n".join(map(_part, SCRIPTS)),
        "meshcat": _meshcat(),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda place: parts[place[1]], _part("page.html"))


def _embedded(data: dict[str, Any]) -> str:
    """Write JSON so that no text in it ends the script element that holds it, whatever a label says."""
    return json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


@cache
def _part(name: str) -> str:
    return (resources.files(__package__) / name).read_text(encoding="utf-8")


@cache
def _meshcat() -> str:
    viewer = resources.files("meshcat") / "viewer" / "dist" / "main.min.js"
    return viewer.read_text(encoding="utf-8").replace("</script", "<\\/script")
