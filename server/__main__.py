"""`python -m server`: the same command line as the console script `jointscope`."""

import sys

from server.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
