"""Runs the pages of configs/tutorials: every command, in small where a page says so, and compares what they print.

Usage: tutorial_test.py PATHFIT SOURCE_DIR [PYTHON MODULE_FOLDER]. Unittest output; exits 1 if anything fails. Without the
Python module its page is skipped.

A page's blocks of `sh` run in one empty folder with `configs/tutorials` and `data` in it; a comment `<!-- CI adds: WORDS -->`
before a block adds options to its one command. Blocks of `text` are what the commands before them printed, without times
of day and the folder: each line must come again, but for its numbers. `...` stands for lines that are left out.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

PATHFIT = pathlib.Path(sys.argv[1]).resolve()
SOURCE = pathlib.Path(sys.argv[2]).resolve()
PYTHON, MODULE = (sys.argv[3], str(pathlib.Path(sys.argv[4]).resolve())) if len(sys.argv) > 3 else (None, "")
TUTORIALS = SOURCE / "configs" / "tutorials"
HEADINGS = ("## With your own data", "## What may go wrong")
MOST_BYTES_OF_PICTURE = 60000

# Runs the tasks of a job array one after the other, as the cluster's own does side by side.
SBATCH = """#!/bin/bash
set -eu
export SLURM_CPUS_PER_TASK=1
[[ $1 =~ ^--array=1-([0-9]+)$ ]] || exec bash "$@"
shift
for task in $(seq "${BASH_REMATCH[1]}"); do
  SLURM_ARRAY_TASK_ID=$task bash "$@"
done
echo "Submitted batch job 1"
"""

# Where it is not installed (680 MB) its page's other commands still run.
SNAKEMAKE = """#!/bin/sh
echo "*** SKIPPED: snakemake is not installed. ***" >&2
"""

# Two tasks of a step on this machine.
SRUN = """#!/bin/bash
exec mpirun -n 2 --oversubscribe "${@:2}"
"""


def blocks(page):
    """(language, text, words that CI adds) of the page's fenced blocks, in order."""
    found = re.findall(r"(?:<!-- CI adds: ([^\n]*) -->\n)?^```(\w*)\n(.*?)^```$", page, re.M | re.S)
    return [(language, text, added) for added, language, text in found]


def shape(line, folder=None):
    """A line without numbers, units of times, time of day and folder."""
    if folder is not None:
        line = line.replace(f"{folder}/", "")
    line = re.sub(r"^\d{4}-\d\d-\d\dT[\d:]+Z ", "", line)
    line = re.sub(r'(kept=|reason=)("[^"]*"|\w+)', r"\1", line)  # how a stage in small ends
    line = re.sub(r"[-+]?(\d+(\.\d+)?|\.\d+)(e[-+]?\d+)?", "#", line)
    line = re.sub(r"# (h # min|min # s|s)\b", "# s", line)  # short times are of seconds alone
    return " ".join(line.split())


class Tutorials(unittest.TestCase):
    maxDiff = None

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="pathfit_tutorial_")).resolve()
        self.addCleanup(shutil.rmtree, self.folder)
        shutil.copytree(TUTORIALS, self.folder / "configs" / "tutorials")
        (self.folder / "data").symlink_to(SOURCE / "data")
        programs = self.folder / "programs"
        programs.mkdir()
        (programs / "pathfit").symlink_to(PATHFIT)
        if PYTHON:
            (programs / "python3").write_text(f'#!/bin/sh\nexec "{PYTHON}" "$@"\n')
            (programs / "python3").chmod(0o755)
        stand_ins = {"sbatch": SBATCH, "srun": SRUN}
        if not shutil.which("snakemake"):
            stand_ins["snakemake"] = SNAKEMAKE
        for name, text in stand_ins.items():
            (programs / name).write_text(text)
            (programs / name).chmod(0o755)
        self.environment = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}", "LC_ALL": "C",
                            "PYTHONPATH": MODULE,
                            "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}

    def run_block(self, text, added):
        if added:
            self.assertNotIn("\n", text.replace("\\\n", "").strip(), "options are added to one command")
            text = text.rstrip() + " " + added
        done = subprocess.run(["bash", "-euo", "pipefail", "-c", text], cwd=self.folder, env=self.environment,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=600)
        self.assertEqual(done.returncode, 0, f"{text}\n{done.stdout}")
        return [shape(line, self.folder) for line in done.stdout.splitlines()]

    def run_page(self, name):
        page = (TUTORIALS / name / "README.md").read_text()
        printed, commands = [], 0
        for language, text, added in blocks(page):
            if language == "sh":
                commands += 1
                printed = self.run_block(text, added)
            elif language == "text":
                for line in text.splitlines():
                    if line.strip() != "...":
                        self.assertIn(shape(line), printed, f"{name}: '{line}' is not printed any more")
        self.assertGreater(commands, 2)
        for heading in HEADINGS:
            self.assertIn(f"\n{heading}\n", page)
        for link in re.findall(r"\]\(([^)#]+)\)", page):
            self.assertTrue(link.startswith("https://") or (TUTORIALS / name / link).exists(), f"{name}: {link}")
        for file in (TUTORIALS / name).iterdir():
            self.assertLess(file.stat().st_size, MOST_BYTES_OF_PICTURE, file)
            self.assertTrue(file.name == "README.md" or file.name in page, f"{name}: nothing is said of {file.name}")

    def test_shape_from_photos(self):
        self.run_page("shape_from_photos")
        drafted = (self.folder / "my_axe.yaml").read_text()
        shown = (TUTORIALS / "shape_from_photos" / "axe.yaml").read_text()
        self.assertEqual(drafted, shown.replace("../../../data/", "data/"), "axe.yaml is not what init writes")

    def test_every_tutorial_is_run(self):
        index = (SOURCE / "README.md").read_text()
        for name in (p.name for p in TUTORIALS.iterdir()):
            self.assertTrue(hasattr(self, f"test_{name}"), name)
            self.assertIn(f"(configs/tutorials/{name}/README.md)", index)

    def test_material_of_a_known_shape(self):
        self.run_page("material_of_a_known_shape")

    def test_photometric_stereo(self):
        self.run_page("photometric_stereo")
        drafted = (self.folder / "my_cat.yaml").read_text().replace("my_cat_start.ply", "data/cat/start.ply")
        shown = (TUTORIALS / "photometric_stereo" / "cat.yaml").read_text()
        self.assertEqual(drafted, shown.replace("../../../data/", "data/"), "cat.yaml is not what init writes")

    def test_scene_with_derivatives(self):
        self.run_page("scene_with_derivatives")

    @unittest.skipUnless(PYTHON, "built without the Python module")
    def test_python(self):
        self.run_page("python")

    def test_on_a_cluster(self):
        self.run_page("on_a_cluster")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
