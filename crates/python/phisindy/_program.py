"""The command ``phisindy``: the same program as the binary."""

import sys

from ._native import program


def main() -> None:
    """Runs the program with the words of the command line."""
    sys.exit(program(sys.argv))
