"""Checks renderer/THEORY.md: every file it names exists, and holds the code names listed beside it.

Usage: theory_test.py REPO_ROOT. Prints every violation, exits 1 if there is any.
"""
import pathlib
import re
import sys

FILE = re.compile(r"`((?:renderer|optim|app|tests|data)/[\w./{},]+\.\w+)`")
NAME = re.compile(r"`([A-Za-z_]\w*)`")


def expanded(name):
    """renderer/a/b.{h,cpp} names two files."""
    if not (braces := re.search(r"\{([^}]*)\}", name)):
        return [name]
    return [name[: braces.start()] + part + name[braces.end():] for part in braces.group(1).split(",")]


def main(root):
    errors = []
    count = 0
    for number, line in enumerate((root / "renderer/THEORY.md").read_text().splitlines(), 1):
        files = [f for match in FILE.findall(line) for f in expanded(match)]
        count += len(files)
        texts = []
        for name in files:
            if (root / name).is_file():
                texts.append((root / name).read_text(errors="replace"))
            else:
                errors.append(f"renderer/THEORY.md:{number}: {name} does not exist")
        # In a table row that names files, every bare code name must occur in one of them.
        if line.startswith("|") and texts:
            for name in NAME.findall(FILE.sub("", line)):
                if not any(re.search(rf"\b{name}\b", text) for text in texts):
                    errors.append(f"renderer/THEORY.md:{number}: {name} is in none of {', '.join(files)}")
    if count == 0:
        errors.append("renderer/THEORY.md names no file")
    print("\n".join(errors) or f"{count} files named, all there")
    return bool(errors)


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
