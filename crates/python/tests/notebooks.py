"""Executes notebooks, each in its own folder; with ``--write`` their outputs replace those in the files."""

import sys
import time
from pathlib import Path

import nbformat
from nbclient import NotebookClient


def main() -> None:
    words = sys.argv[1:]
    write = "--write" in words
    for path in (Path(word) for word in words if word != "--write"):
        begin = time.monotonic()
        notebook = nbformat.read(path, as_version=4)
        folder = {"metadata": {"path": str(path.parent)}}
        NotebookClient(notebook, timeout=300, kernel_name="python3", resources=folder).execute()
        for cell in notebook.cells:
            # When a cell ran says nothing, and changes with every run.
            cell.metadata.pop("execution", None)
        if write:
            notebook.metadata = {"kernelspec": notebook.metadata["kernelspec"], "language_info": {"name": "python"}}
            nbformat.write(notebook, path)
        print(f"{path}: {time.monotonic() - begin:.1f} s")


if __name__ == "__main__":
    main()
