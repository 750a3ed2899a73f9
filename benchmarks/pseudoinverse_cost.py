"""Compare the cost of pseudoinverses, ticks and runs: the same as `aspect-control bench`."""

import sys

from aspect_control.cli import main

if __name__ == "__main__":
    sys.argv.insert(1, "bench")
    main()
