"""A stand-in for meshcat's window that keeps the drawing commands instead of sending them to a server."""

from __future__ import annotations

from typing import Any

import meshcat
import umsgpack


class CommandRecorder:
    """Keeps the commands that a `meshcat.Visualizer` sends, so that a scene needs no server and opens no socket.

    Attributes:
        commands: The commands, packed as meshcat's viewer reads them, in the order in which they were sent.
    """

    def __init__(self) -> None:
        """Start without commands."""
        self.commands: list[bytes] = []

    def send(self, command: Any) -> None:
        """Keep a command of `meshcat.commands`."""
        self.commands.append(umsgpack.packb(command.lower()))

    def visualizer(self) -> Any:
        """Return a `meshcat.Visualizer` at the root of the scene that draws into this recorder."""
        return meshcat.Visualizer(window=self)
