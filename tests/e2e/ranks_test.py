"""Runs the program over several MPI processes of this machine: the bits of one, whatever happens on the way.

Usage: ranks_test.py PATHFIT SOURCE_DIR MPIRUN. Unittest output; exits 1 if anything fails.
"""
import filecmp
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PATHFIT, SOURCE, MPIRUN = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3]
sys.path.insert(0, str(SOURCE / "tests" / "support"))
from run_state import final_bytes  # noqa: E402

# Light by few unknowns, all by many, held-out views: a few rounds of each.
FIT = ["--progress", "none", "-q", "--threads", "1", "--set", "input.split.validation=every 6"]
for stage in ("light", "all"):
    FIT += ["--set", f"stages.{stage}.max_rounds=3", "--set", f"stages.{stage}.image_scale=0.1875",
            "--set", f"stages.{stage}.spp=2", "--set", f"stages.{stage}.max_spp=4"]
LAMP = SOURCE / "configs" / "tutorials" / "on_a_cluster" / "found_lamp.yaml"
ENVIRONMENT = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}


def command(ranks, *arguments):
    words = [] if ranks == 1 else [MPIRUN, "--oversubscribe", "-n", str(ranks)]
    return words + [str(PATHFIT), *map(str, arguments)]


def run(ranks, *arguments):
    return subprocess.run(command(ranks, *arguments), capture_output=True, text=True, timeout=300, env=ENVIRONMENT)


def children(pid):
    """Processes of the program that mpirun has started."""
    found = []
    for status in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            name, rest = status.read_text().split("(", 1)[1].rsplit(")", 1)
        except (FileNotFoundError, ProcessLookupError):
            continue
        if name == PATHFIT.name and int(rest.split()[1]) == pid:
            found.append(int(status.parent.name))
    return sorted(found)


class Ranks(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="pathfit_ranks_"))
        cls.fit(1, "one")
        cls.expected = final_bytes(cls.root / "one")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.root)

    @classmethod
    def fit(cls, ranks, name):
        done = run(ranks, "fit", SOURCE / "configs" / "axe_demo.yaml", "-o", cls.root / name, *FIT)
        assert done.returncode == 0, done.stderr

    def assert_expected(self, name):
        found = final_bytes(self.root / name)
        self.assertEqual(found.keys(), self.expected.keys())
        for key, value in self.expected.items():
            self.assertTrue(found[key] == value, f"{name}: {key} differs")

    def stopped(self, name, ranks, send):
        """A fit on which `send` is called with the program's processes once there are checkpoints; mpirun."""
        arguments = command(ranks, "fit", SOURCE / "configs" / "axe_demo.yaml", "-o", self.root / name, *FIT)
        with subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                              env=ENVIRONMENT) as launcher:
            while launcher.poll() is None and not list((self.root / name).glob("checkpoints/state_*.cbor")):
                time.sleep(0.02)
            send(launcher, children(launcher.pid))
            _, launcher.said = launcher.communicate(timeout=120)
        return launcher

    def test_fits_have_the_bits_of_one_process(self):
        for ranks in (2, 4, 8):
            self.fit(ranks, f"ranks_{ranks}")
            self.assert_expected(f"ranks_{ranks}")

    def test_rank_that_dies_ends_all_and_another_number_of_ranks_goes_on(self):
        launcher = self.stopped("killed", 4, lambda _, ranks: os.kill(ranks[-1], signal.SIGKILL))
        self.assertNotEqual(launcher.returncode, 0)
        self.assertIn("signal 9", launcher.said)
        done = run(2, "resume", self.root / "killed", "-q", "--threads", "1")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assert_expected("killed")

    def test_any_rank_told_to_stop_stops_all_resumably(self):
        launcher = self.stopped("told", 2, lambda _, ranks: os.kill(ranks[-1], signal.SIGTERM))
        self.assertEqual(launcher.returncode, 75, launcher.said)
        record = json.loads((self.root / "told" / "run.json").read_text())
        self.assertEqual(record["status"], "stopped")
        done = run(1, "resume", self.root / "told", "-q", "--threads", "1")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assert_expected("told")

    def test_launcher_told_to_stop_leaves_a_checkpoint(self):
        launcher = self.stopped("ended", 2, lambda launcher, _: launcher.terminate())
        self.assertNotEqual(launcher.returncode, 0)
        done = run(3, "resume", self.root / "ended", "-q", "--threads", "1")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assert_expected("ended")

    def test_render_and_gradcheck_have_the_bits_of_one_process(self):
        for name, arguments in (("render", ["--spp", "8", "--derivative", "lamp.intensity"]),
                                ("gradcheck", ["--spp", "8", "--replicates", "4", "--params", "lamp.*"])):
            for ranks in (1, 3):
                done = run(ranks, name, LAMP, "-o", self.root / f"{name}_{ranks}", "-q", "--threads", "1", *arguments)
                self.assertEqual(done.returncode, 0, done.stderr)
            a, b = self.root / f"{name}_1", self.root / f"{name}_3"
            files = sorted(p.name for p in a.iterdir())
            self.assertGreater(len(files), 8)
            self.assertEqual(files, sorted(p.name for p in b.iterdir()))
            self.assertEqual(filecmp.cmpfiles(a, b, files, shallow=False)[0], files)

    def test_wrong_input_is_said_once(self):
        done = run(3, "fit", "nowhere.yaml")
        self.assertEqual(done.returncode, 3)
        self.assertEqual(done.stderr.count("the config cannot be opened"), 1)

    def test_what_one_rank_alone_finds_wrong_is_said_with_its_number(self):
        here = command(1, "fit", SOURCE / "configs" / "axe_demo.yaml", "-o", self.root / "alone", *FIT)
        there = command(1, "fit", "nowhere.yaml")
        done = subprocess.run([MPIRUN, "--oversubscribe", "-n", "1", *here, ":", "-n", "1", *there],
                              capture_output=True, text=True, timeout=300, env=ENVIRONMENT)
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("rank 1: nowhere.yaml", done.stderr)

    def test_what_runs_in_one_process_says_so(self):
        done = run(2, "synth", LAMP, "-o", self.root / "photos")
        self.assertEqual(done.returncode, 2)
        self.assertIn("start it without mpirun", done.stderr)
        self.assertFalse((self.root / "photos").exists())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
