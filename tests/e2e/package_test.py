"""Makes the Debian packages, unpacks them and runs the program.

Usage: package_test.py BUILD_FOLDER. Prints what went wrong, exits 1 if anything did.
"""
import pathlib
import subprocess
import sys
import tempfile


def run(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(str(part) for part in command)}\n{done.stdout}{done.stderr}")
    return done.stdout


def package_in(folder, name):
    found = list(folder.glob(f"{name}_*.deb"))
    if len(found) != 1:
        sys.exit(f"{name}: {len(found)} packages instead of one")
    return found[0]


def main(build):
    with tempfile.TemporaryDirectory(prefix="pathfit-package-") as name:
        folder = pathlib.Path(name)
        run("cpack", "-G", "DEB", "--config", build / "CPackConfig.cmake", "-B", folder / "made")
        program, libraries = package_in(folder / "made", "pathfit"), package_in(folder / "made", "libpathfit-dev")
        depends = run("dpkg-deb", "-f", program, "Depends")
        for needed in ("libembree3", "libstdc++6"):
            if needed not in depends:
                sys.exit(f"pathfit does not depend on {needed}: {depends}")
        if "-dev" in depends:
            sys.exit(f"the program's package asks for files of builds: {depends}")
        # What a build needs that finds the libraries is what our own build needs.
        for needed in run("dpkg-deb", "-f", libraries, "Depends").strip().split(", "):
            run("dpkg-query", "-W", needed)
        for package in (folder / "made").glob("*.deb"):
            run("dpkg-deb", "-x", package, folder / "root")
        if "pathfit" not in run(folder / "root/usr/bin/pathfit", "--version"):
            sys.exit("usr/bin/pathfit --version does not name the program")
        for file in ("lib/cmake/pathfit/pathfitConfig.cmake", "include/pathfit/renderer/renderer.h", "share/man/man1/pathfit.1"):
            if not (folder / "root/usr" / file).is_file():
                sys.exit(f"usr/{file} is in no package")
        if "PATHFIT_PYTHON:BOOL=ON" in (build / "CMakeCache.txt").read_text():
            if "python3-numpy" not in run("dpkg-deb", "-f", package_in(folder / "made", "python3-pathfit"), "Depends"):
                sys.exit("python3-pathfit does not depend on python3-numpy")
            if not list((folder / "root/usr/lib/python3/dist-packages").glob("pathfit*.so")):
                sys.exit("the Python module is in no package")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
