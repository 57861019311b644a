"""Checks that the files CONTRIBUTING.md names exist, and renderer/THEORY.md: every file it names exists and holds the
code names listed beside it; every number of its
table has the value it has in the code; and every numeric constant of the renderer is in that table.

Usage: theory_test.py REPO_ROOT. Prints every violation, exits 1 if there is any.
"""
import pathlib
import re
import sys

FILE = re.compile(r"`((?:renderer|optim|app|tests|data)/[\w./{},]+)`")
NAME = re.compile(r"`([A-Za-z_]\w*)`")
CONSTANT = re.compile(r"\bconstexpr\s[^;(){}]*?\b(k[A-Z]\w*)\s*=\s*-?(?:0x)?[\d.]")
# Names for bits and places of a list or a file format, and answers that are no number.
NO_NUMBERS = {"kAbsent", "kNobody", "kFx", "kCx", "kTiffWidth", "kTiffHeight", "kTiffOrientation",
              "kHeaderBytes", "kTriangleBytes", "kNormalBytes"}


def expanded(name):
    """renderer/a/b.{h,cpp} names two files."""
    if not (braces := re.search(r"\{([^}]*)\}", name)):
        return [name]
    return [name[: braces.start()] + part + name[braces.end():] for part in braces.group(1).split(",")]


def holds_value(text, name, value):
    found = re.findall(rf"\b{name}\s*=\s*([^;,}}]+)", text)
    return any(re.fullmatch(rf"{re.escape(value)}(?:F|ULL)?", literal.strip()) for literal in found)


def check_lines(root, lines):
    """Returns errors, how many files are named, and the constants with a value by file."""
    errors, count, constants = [], 0, set()
    numbers = False
    for line_number, line in enumerate(lines, 1):
        if line.startswith("#"):
            numbers = line.startswith("## ") and "Numbers" in line
        place = f"renderer/THEORY.md:{line_number}"
        files = [f for match in FILE.findall(line) for f in expanded(match)]
        count += len(files)
        texts = {}
        for name in files:
            if (root / name).is_file():
                texts[name] = (root / name).read_text(errors="replace")
            else:
                errors.append(f"{place}: {name} does not exist")
        if not line.startswith("|") or not texts:
            continue
        # In a table row that names files, every bare code name must occur in one of them.
        names = NAME.findall(FILE.sub("", line))
        for name in names:
            if not any(re.search(rf"\b{name}\b", text) for text in texts.values()):
                errors.append(f"{place}: {name} is in none of {', '.join(files)}")
        if numbers:
            cells = [cell.strip() for cell in line.strip("|").split(" | ")]
            names, values = NAME.findall(cells[0]), cells[1].split(", ")
            if len(names) != len(values):
                errors.append(f"{place}: {len(names)} names and {len(values)} values")
            for name, value in zip(names, values):
                holders = [f for f, text in texts.items() if holds_value(text, name, value)]
                constants |= {(name, f) for f in holders}
                if not holders:
                    errors.append(f"{place}: {name} is not {value} in {', '.join(files)}")
    return errors, count, constants


def check_contributing(root):
    """The files that are named exist; in the table, other names stand in a file of their row, and `_fit` behind
    `app/config/schema_input.cpp` means `app/config/schema_fit.cpp`."""
    errors = []
    for number, line in enumerate((root / "CONTRIBUTING.md").read_text().splitlines(), 1):
        files = [name for match in FILE.findall(line) for name in expanded(match) if "NAME" not in name]
        names = NAME.findall(FILE.sub("", line)) if line.startswith("|") else []
        files += [re.sub(r"_[a-z]+(?=\.)", name, file) for name in names if name.startswith("_")
                  for file in files if "/schema_" in file]
        errors += [f"CONTRIBUTING.md:{number}: {name} does not exist" for name in files if not (root / name).exists()]
        texts = [(root / name).read_text(errors="replace") for name in files if (root / name).is_file()]
        errors += [f"CONTRIBUTING.md:{number}: {name} is in none of {', '.join(files)}" for name in names
                   if not name.startswith("_") and texts and not any(re.search(rf"\b{name}\b", t) for t in texts)]
    return errors


def main(root):
    errors, count, constants = check_lines(root, (root / "renderer/THEORY.md").read_text().splitlines())
    if count == 0:
        errors.append("renderer/THEORY.md names no file")
    errors += check_contributing(root)
    for path in sorted((root / "renderer").rglob("*")):
        if path.suffix in {".h", ".cpp"}:
            name_of_file = str(path.relative_to(root))
            for name in CONSTANT.findall(path.read_text(errors="replace")):
                if name not in NO_NUMBERS and (name, name_of_file) not in constants:
                    errors.append(f"{name_of_file}: {name} is not in the numbers of renderer/THEORY.md")
    print("\n".join(errors) or f"{count} files named, {len(constants)} numbers, all as they are")
    return bool(errors)


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
