"""C text without comments and literals, line numbers kept: shared by the gates that read sources."""
import pathlib
import re

_TOKEN = re.compile(r"//[^\n]*|/\*.*?\*/|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'", re.DOTALL)


def code_of(text, keep_strings=False):
    """The text with comments (and strings) blanked out."""

    def blank(match):
        token = match.group(0)
        if token[0] == "/":
            return " " + "\n" * token.count("\n")
        return token if keep_strings else token[0] * 2

    return _TOKEN.sub(blank, text)


def includes_of(path):
    """(line number, name, quoted?) of each #include."""
    lines = code_of(path.read_text(), keep_strings=True).splitlines()
    for number, line in enumerate(lines, 1):
        match = re.match(r'\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>)', line)
        if match:
            yield number, match.group(1) or match.group(2), bool(match.group(1))


def files(root, *folders):
    """All .c and .h files below the folders, sorted; folders may be missing."""
    for folder in folders:
        yield from sorted(p for p in pathlib.Path(root, folder).rglob("*.[ch]") if p.is_file())
