"""Tables of the documents, as the program `phisindy-blind` writes them: between two marks, nothing else is touched."""
import pathlib
import re


def markdown(head, rows):
    """A table as lines of Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines) + "\n"


def write(path, name, text):
    """Puts `text` between the marks `<!-- table:NAME -->` and `<!-- end -->` of a document."""
    path = pathlib.Path(path)
    old = path.read_text()
    begin = f"<!-- table:{name} -->\n"
    found = re.search(re.escape(begin) + r".*?(?=<!-- end -->)", old, re.S)
    if found is None:
        raise SystemExit(f"{path}: there is no {begin.strip()} with an end")
    path.write_text(old[: found.start()] + begin + text + old[found.end() :])
