"""Checks that the public headers (scripts/cmake/public_headers.cmake) are closed under inclusion.

Usage: public_headers_test.py REPO_ROOT. Prints every violation, exits 1 if there is any.
"""
import pathlib
import re
import sys

LIST = "scripts/cmake/public_headers.cmake"


def main(root):
    text = re.sub(r"#.*", "", (root / LIST).read_text())
    public = re.findall(r"[\w/]+\.h\b", text)
    errors = [f"{LIST}: {h} is listed twice" for h in sorted({h for h in public if public.count(h) > 1})]
    for header in public:
        if not (root / header).is_file():
            errors.append(f"{LIST}: {header} does not exist; if it was moved or merged, write its new name")
            continue
        for kind, include in re.findall(r'^\s*#include ([<"])([^>"]+)', (root / header).read_text(), re.M):
            if kind == '"' and include not in public:
                errors.append(f"{header} is public and includes {include}: add that to {LIST}, or declare forward what "
                              f"it is included for")
            if kind == "<" and not re.fullmatch(r"[a-z_0-9]+", include):
                errors.append(f"{header} is public and includes <{include}>: third-party headers stay inside")
    print("\n".join(errors) or f"{len(public)} public headers")
    return bool(errors)


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
