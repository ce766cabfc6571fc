"""``python -m phisindy``: the command ``phisindy``."""

from ._program import main

main()
