"""The three-dimensional scene of a replay: robots, pages and the live server."""
