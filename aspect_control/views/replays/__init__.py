"""Replays in a browser, recorded and live; they need meshcat, which is loaded when they are asked for."""
