"""Installs the built tree into a new prefix and builds a program of somebody else against it.

Usage: install_test.py BUILD_FOLDER REPO_ROOT CXX. Prints what went wrong, exits 1 if anything did.
"""
import pathlib
import re
import subprocess
import sys
import tempfile


def run(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(str(part) for part in command)}\n{done.stdout}{done.stderr}")
    return done.stdout


def main(build, root, compiler):
    with tempfile.TemporaryDirectory(prefix="pathfit-install-") as folder:
        prefix, program = pathlib.Path(folder) / "prefix", pathlib.Path(folder) / "program"
        run("cmake", "--install", build, "--prefix", prefix)
        for header in (prefix / "include").rglob("*.h"):
            if wrong := re.findall(r'#include "(?!pathfit/)[^"]*"', header.read_text()):
                sys.exit(f"{header}: {wrong[0]} is not installed")
        if "pathfit" not in run(prefix / "bin/pathfit", "--version"):
            sys.exit("bin/pathfit --version does not name the program")
        for file, text in (("man/man1/pathfit.1", ".TH PATHFIT"), ("bash-completion/completions/pathfit", "complete -F"),
                           ("zsh/site-functions/_pathfit", "#compdef pathfit"),
                           ("fish/vendor_completions.d/pathfit.fish", "complete -c pathfit")):
            if text not in (prefix / "share" / file).read_text():
                sys.exit(f"share/{file} does not hold {text}")
        run("cmake", "-S", root / "tests/install", "-B", program, f"-DCMAKE_PREFIX_PATH={prefix}",
            f"-DCMAKE_CXX_COMPILER={compiler}")
        run("cmake", "--build", program)
        print(run(program / "derivative_of_a_ball"), end="")


if __name__ == "__main__":
    main(sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3])
