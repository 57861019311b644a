"""The smaller commands on a small set of photos: answers as JSON, reports of killed runs, converted cameras, sweeps.

Usage: command_test.py PATHFIT SOURCE_DIR. Unittest output; exits 1 if anything fails.
"""
import csv
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from truth_test import PATHFIT, SCENE, SOURCE, run


class Commands(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="pathfit_command_"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        (cls.folder / "lamps.yaml").write_text(SCENE)
        cls.done("synth", cls.folder / "lamps.yaml", "-o", cls.folder / "set", "--spp", "32")
        cls.config = cls.folder / "set" / "fit.yaml"
        cls.config.write_text(cls.config.read_text().replace("intensity: [6, 6, 6]", "intensity: [3, 3, 3]"))
        cls.done("fit", cls.config, "-o", cls.folder / "run", "-q", "--set", "stages.all.max_rounds=2")

    @classmethod
    def done(cls, *arguments, status=0, **options):
        result = subprocess.run([PATHFIT, *map(str, arguments)], capture_output=True, text=True, timeout=600, **options)
        assert result.returncode == status, f"{arguments}: {result.returncode} {result.stderr}"
        return result

    def setUp(self):
        self.own = pathlib.Path(tempfile.mkdtemp(dir=self.folder))

    def test_every_answer_is_one_object_that_says_its_schema(self):
        quick = ["--set", "gradcheck.spp=2", "--set", "gradcheck.replicates=2"]
        commands = [
            ["init", self.folder / "set", "-o", self.own / "a.yaml"], ["check", self.config],
            ["fit", self.config, "-o", self.own / "b", "--set", "stages.all.max_rounds=1"], ["resume", self.own / "b"],
            ["render", self.folder / "run", "--views", "0", "--spp", "1", "-o", self.own / "c"],
            ["export", self.folder / "run", "--to", "glb,transforms", "-o", self.own / "d"],
            ["report", self.folder / "run", "-o", self.own / "e.html"], ["list", self.own],
            ["compare", self.folder / "run", self.own / "b", "-o", self.own / "f.html"],
            ["eval", self.folder / "run", "--truth", self.folder / "set", "--spp", "2", "--points", "500"],
            ["sweep", self.config, "--seeds", "2", "--list"],
            ["synth", self.folder / "lamps.yaml", "-o", self.own / "g", "--spp", "1"],
            ["convert", "cameras", self.folder / "set" / "transforms.json", self.own / "h"],
            ["gradcheck", self.config, "--params", "paint.base_color.r", *quick],
            ["config", "show", self.config], ["config", "schema"], ["info"], ["version"]]
        for words in commands:
            out = run(*words, "--json", "-q")
            self.assertIn(out.returncode, (0, 7) if words[0] == "gradcheck" else (0,), f"{words}: {out.stderr}")
            self.assertEqual(json.loads(out.stdout)["schema"], f"pathfit-{words[0]}-1", words)
            self.assertEqual(out.stderr, "", f"{words}: -q is quiet")
        # All commands but those that print text, and the one that goes on (page_test.py).
        listed = re.findall(r"^  (\w+) ", self.done("--help").stdout.split("Subcommands:")[1], re.M)
        self.assertEqual(set(listed), {words[0] for words in commands} | {"completion", "help", "serve"})

    def test_list_says_how_far_the_runs_in_a_folder_are(self):
        for name in ("runs/a/1", "runs/a/2", "runs/b"):
            shutil.copytree(self.folder / "run", self.own / name)
        (self.own / "runs/a/latest").symlink_to("2")
        (self.own / "runs/empty").mkdir()
        record = json.loads((self.own / "runs/b/run.json").read_text())
        record.update(status="running", started_utc="2020-01-01T00:00:00Z")
        record["sessions"][-1]["pid"] = 2 ** 22 + 1  # above the largest
        (self.own / "runs/b/run.json").write_text(json.dumps(record))
        (self.own / "runs/a/2/run.json").write_text("{")
        listed = json.loads(self.done("list", "--json", "-q", cwd=self.own).stdout)
        self.assertEqual(listed["folder"], str(self.own / "runs"))
        self.assertEqual([pathlib.Path(run["run"]).relative_to(self.own / "runs").as_posix() for run in listed["runs"]],
                         ["a/2", "b", "a/1"], "what cannot be read, then by their start")
        self.assertEqual([run["status"] for run in listed["runs"]], ["unreadable", "killed", "finished"])
        broken, _, run = listed["runs"]
        self.assertEqual(set(broken.values()) - {broken["run"]}, {None, "unreadable"})
        history = json.loads((self.folder / "run/history.json").read_text())
        self.assertEqual((run["name"], run["stages"], run["rounds"]), ("lamps", 1, len(history["rounds"])))
        self.assertGreater(run["wall_s"], 0.0)
        out = self.done("list", self.own / "runs/a")
        lines = out.stdout.splitlines()
        self.assertRegex(lines[0], "^Run +Name +Status +Started +Stages +Rounds +PSNR sRGB held out +Time$")
        self.assertRegex(lines[1], "^2 +- +unreadable( +-)+$")
        self.assertRegex(lines[2], r"^1 +lamps +finished +20\S+Z +1 +\d+ ")
        self.assertIn("run.json: is not a run's record", out.stderr)
        self.assertEqual(json.loads(self.done("list", self.own / "runs/empty", "--json").stdout)["runs"], [])
        self.assertIn("is no folder", self.done("list", self.own / "none", status=4).stderr)

    def test_config_show_says_where_each_value_comes_from(self):
        out = self.done("config", "show", self.config, "--set", "render.spp=9", "--seed", "4").stdout
        self.assertIn("spp: 9  # --set #1\n", out)
        self.assertIn("seed: 4  # --seed\n", out)
        self.assertRegex(out, r"name: lamps  # fit.yaml:\d+\n")
        self.assertIn("rr_depth: 5  # default\n", out)
        (self.own / "again.yaml").write_text(out)
        again = json.loads(self.done("config", "show", self.own / "again.yaml", "--json").stdout)
        self.assertEqual(again["values"]["render"]["spp"], 9)
        wrong = self.done("config", "show", self.config, "--set", "rendr.spp=9", status=3)
        self.assertIn("did you mean 'render'", wrong.stderr)

    def test_a_killed_run_has_a_report(self):
        folder = self.own / "killed"
        process = subprocess.Popen([PATHFIT, "fit", self.config, "-o", folder, "--progress", "none", "--set",
                                    "stages.all.max_rounds=200", "--set", "stages.all.spp=64"],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        deadline = time.monotonic() + 120
        while not list(folder.glob("checkpoints/state_*")) and time.monotonic() < deadline:
            time.sleep(0.02)
        running = json.loads(self.done("report", folder, "--json", "-o", self.own / "running.html").stdout)
        self.assertEqual(running["status"], "running")
        process.kill()
        process.wait()
        (folder / "report.html").unlink(missing_ok=True)
        result = json.loads(self.done("report", folder, "--json").stdout)
        self.assertEqual((result["status"], result["page"]), ("killed", str(folder / "report.html")))
        page = (folder / "report.html").read_text()
        self.assertIn("The process ended without a word", page)
        nothing = self.done("report", self.folder / "set", status=4)
        self.assertIn("is not a run directory", nothing.stderr)

    def test_a_rebuilt_report_is_the_one_of_the_fit(self):
        before = (self.folder / "run" / "report.html").read_bytes()
        self.assertEqual(self.done("report", self.folder / "run").stdout.strip(), str(self.folder / "run" / "report.html"))
        self.assertTrue(before == (self.folder / "run" / "report.html").read_bytes())

    def test_cameras_are_converted_there_and_back(self):
        source = self.folder / "run" / "result" / "cameras" / "transforms.json"
        self.done("convert", "cameras", source, self.own / "a.json")
        self.done("convert", "cameras", self.own / "a.json", self.own / "b.json")
        self.assertEqual((self.own / "a.json").read_bytes(), (self.own / "b.json").read_bytes())
        frames = [json.loads(path.read_text())["frames"] for path in (source, self.own / "a.json")]
        for before, after in zip(*frames):
            photo = self.own / after.pop("file_path")
            self.assertTrue(photo.is_file(), "the photo is found from the new place")
            self.assertEqual(photo.name, pathlib.Path(before.pop("file_path")).name)
            self.assertEqual(before, after)
        self.done("convert", "cameras", self.own / "a.json", self.own / "list.yaml")
        self.done("convert", "cameras", self.own / "list.yaml", self.own / "d.json")
        self.assertEqual((self.own / "a.json").read_bytes(), (self.own / "d.json").read_bytes())
        self.done("convert", "cameras", self.own / "a.json", self.own / "model")
        self.assertEqual(sorted(os.listdir(self.own / "model")), ["cameras.txt", "images.txt", "points3D.txt"])
        self.assertRegex((self.own / "model" / "images.txt").read_text(), r" 1 a\.exr\n")
        self.done("convert", "cameras", self.own / "model", self.own / "c.json")
        back = json.loads((self.own / "c.json").read_text())["frames"]
        for before, after in zip(frames[1], back):
            self.assertEqual((before["fl_x"], before["cy"]), (after["fl_x"], after["cy"]))
            for i in range(4):
                for j in range(4):
                    self.assertAlmostEqual(before["transform_matrix"][i][j], after["transform_matrix"][i][j], delta=1e-13)
        cameras = json.loads((self.own / "a.json").read_text())
        cameras["frames"][0]["v1"] = -0.2
        (self.own / "vignetting.json").write_text(json.dumps(cameras))
        lossy = self.done("convert", "cameras", self.own / "vignetting.json", self.own / "model2")
        self.assertIn("that of 1 cameras is not written", lossy.stderr)
        unknown = self.done("convert", "cameras", source, self.own / "cameras.xml", status=2)
        self.assertIn("says no format that is written", unknown.stderr)
        exists = self.done("convert", "cameras", source, self.own / "a.json", status=2)
        self.assertIn("--force overwrites", exists.stderr)
        self.assertIn("no such camera file", self.done("convert", "cameras", "gone", self.own / "d.json", status=4).stderr)
        (self.own / "open.json").write_text('{"camera_angle_x": 1, "frames": [{"file_path": "gone", "transform_matrix": '
                                            '[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]}')
        sizeless = self.done("convert", "cameras", self.own / "open.json", self.own / "e", status=4)
        self.assertRegex(sizeless.stderr, r"frames\[0\]: says no size .* --images DIR")
        self.assertFalse((self.own / "e").exists())

    def sweep(self, folder, *more, **options):
        return self.done("sweep", self.config, "-o", folder, "--vary", "stages.all.max_rounds=1,3", "--vary",
                         "scene.lights.left.intensity=[3, 3, 3],[5, 5, 5]", "--progress", "none", *more, **options)

    def table(self, folder):
        rows = list(csv.DictReader((folder / "table.csv").read_text().splitlines()))
        for row in rows:
            del row["wall_s"], row["peak_rss_mb"]
        return rows

    def test_a_sweep_that_was_killed_goes_on_and_ends_with_the_same_table(self):
        out = self.sweep(self.own / "straight")
        rows = self.table(self.own / "straight")
        self.assertEqual([row["stages.all.max_rounds"] for row in rows], ["1", "1", "3", "3"])
        self.assertEqual([row["scene.lights.left.intensity"] for row in rows[:2]], ["[3, 3, 3]", "[5, 5, 5]"])
        self.assertEqual({row["status"] for row in rows}, {"finished"})
        self.assertEqual([row["rounds"] for row in rows], ["1", "1", "3", "3"])
        self.assertEqual(len(out.stdout.splitlines()), 5)
        command = [PATHFIT, "sweep", self.config, "-o", self.own / "killed", "--vary", "stages.all.max_rounds=1,3",
                   "--vary", "scene.lights.left.intensity=[3, 3, 3],[5, 5, 5]", "--progress", "none"]
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        deadline = time.monotonic() + 120
        while len(list((self.own / "killed").glob("0*"))) < 3 and time.monotonic() < deadline:
            time.sleep(0.01)
        process.kill()
        process.wait()
        first = next((self.own / "killed").glob("001*")) / "run.json"
        before = first.read_bytes()
        for _ in range(100):  # the run that was under way ends a moment later
            again = run(*command[1:])
            if again.returncode == 0:
                break
            self.assertIn("another process", again.stderr)
            time.sleep(0.1)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual(first.read_bytes(), before, "what was done is not done again")
        self.assertEqual(self.table(self.own / "killed"), rows)

    def test_a_stopped_sweep_says_how_to_go_on(self):
        process = subprocess.Popen([PATHFIT, "sweep", self.config, "-o", self.own / "stopped", "--seeds", "3", "--set",
                                    "stages.all.max_rounds=200", "--set", "stages.all.spp=64", "--progress", "none"],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        deadline = time.monotonic() + 120
        while not list((self.own / "stopped").glob("0*/checkpoints/state_*")) and time.monotonic() < deadline:
            time.sleep(0.01)
        process.send_signal(signal.SIGTERM)
        _, text = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 75, text)
        self.assertIn("the same command goes on", text)
        self.assertEqual(len(list((self.own / "stopped").glob("0*"))), 1)

    def test_the_list_of_a_sweep_makes_the_same_runs(self):
        listed = self.sweep(self.own / "list", "--list").stdout.splitlines()
        self.assertEqual(len(listed), 4)
        self.assertFalse((self.own / "list").exists())
        for line in reversed(listed):
            subprocess.run(["sh", "-c", line], check=True, capture_output=True, timeout=600)
        self.sweep(self.own / "list")
        self.sweep(self.own / "straight")
        self.assertEqual(self.table(self.own / "list"), self.table(self.own / "straight"))

    def test_a_wrong_sweep_runs_nothing(self):
        for word, pattern in (("stages.all.max_round=1,2", "did you mean 'max_rounds'"),
                              ("stages.all.max_rounds=1,many", "'many' is not a whole number"),
                              ("render.spp=1,0", "out of range")):
            out = self.done("sweep", self.config, "--vary", word, "-o", self.own / "wrong", status=3)
            self.assertRegex(out.stderr, pattern)
            self.assertFalse((self.own / "wrong").exists())
        (self.own / "mine").mkdir()
        (self.own / "mine" / "a").write_text("mine")
        self.assertIn("is not empty", self.done("sweep", self.config, "--seeds", "2", "-o", self.own / "mine", status=2).stderr)

    def test_a_run_of_a_sweep_that_fails_does_not_end_it(self):
        out = self.done("sweep", self.config, "--vary", "solver.max_memory=1 KiB,8 GiB", "-o", self.own / "s", "--set",
                        "stages.all.max_rounds=1", "--json", status=8)
        self.assertEqual([row["status"] for row in json.loads(out.stdout)["runs"]], ["failed", "finished"])

    def test_two_sweeps_in_one_folder_do_each_run_once(self):
        command = [PATHFIT, "sweep", self.config, "-o", self.own / "s", "--seeds", "3", "--set", "stages.all.max_rounds=2",
                   "--progress=none"]
        both = [subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) for _ in range(2)]
        for process in both:
            text = process.communicate(timeout=600)[1]
            self.assertIn(process.returncode, (0, 4), text)
            self.assertEqual("another process" in text, process.returncode == 4, text)
        self.done(*command[1:])
        self.assertEqual([row["status"] for row in self.table(self.own / "s")], ["finished"] * 3)
        for record in self.own.glob("s/0*/run.json"):
            self.assertEqual(len(json.loads(record.read_text())["sessions"]), 1, record)

    def test_a_damaged_run_does_not_end_a_sweep(self):
        command = ["sweep", self.config, "-o", self.own / "s", "--seeds", "2", "--set", "stages.all.max_rounds=1"]
        self.assertNotIn(" of 2)", self.done(*command).stdout)
        records = sorted(self.own.glob("s/0*/run.json"))
        records[0].write_text("{")
        shutil.rmtree(records[1].parent)
        out = self.done(*command, status=4)
        self.assertIn("remove the folder and repeat", out.stderr)
        self.assertEqual([row["status"] for row in self.table(self.own / "s")], ["damaged", "finished"])
        self.assertIn("1-2 (1 of 2)", out.stdout)
        shutil.rmtree(records[0].parent)
        self.done(*command)

    def test_a_sweep_works_where_its_children_would_be_ignored(self):
        self.done("sweep", self.config, "-o", self.own / "s", "--seeds", "2", "--set", "stages.all.max_rounds=1",
                  preexec_fn=lambda: signal.signal(signal.SIGCHLD, signal.SIG_IGN))

    def test_a_sweep_refuses_folders_that_its_runs_would_rename(self):
        for word in ("{name}", "{timestamp}", "${HOME}"):
            out = self.done("sweep", self.config, "-o", self.own / word, "--seeds", "2", status=2)
            self.assertIn("cannot hold", out.stderr)
            self.assertFalse((self.own / word).exists())

    def test_a_sweep_of_too_many_runs_is_refused_at_once(self):
        keys = [f"--vary=scene.lights.left.intensity{i}=" + ",".join(map(str, range(2000))) for i in range(4)]
        self.assertIn("more than 10000 runs", self.done("sweep", self.config, *keys, status=2).stderr)

    def test_what_happened_to_a_stopped_run_is_said(self):
        shutil.copytree(self.folder / "set", self.own / "set")
        folder = self.own / "run"
        process = subprocess.Popen([PATHFIT, "fit", self.own / "set" / "fit.yaml", "-o", folder, "-q", "--set",
                                    "stages.all.max_rounds=200", "--set", "stages.all.spp=64"], stdout=subprocess.DEVNULL)
        deadline = time.monotonic() + 120
        while len(list(folder.glob("checkpoints/state_*.cbor"))) < 2 and time.monotonic() < deadline:
            time.sleep(0.01)
        process.terminate()
        self.assertEqual(process.wait(60), 75)
        newest = max(folder.glob("checkpoints/state_*.cbor"))
        newest.write_bytes(newest.read_bytes()[:500])
        again = self.done("resume", folder, "--time-limit", "1s", "--progress", "none", status=75)
        self.assertRegex(again.stderr, rf"(?s)warning .*{newest.name}.*resuming")

        photo = self.own / "set" / "photos" / "side.exr"
        kept = photo.read_bytes()
        photo.unlink()
        self.assertRegex(self.done("resume", folder, status=4).stderr, r"the photo .*side\.exr is missing")
        photo.write_bytes((photo.parent / "a.exr").read_bytes())
        self.assertRegex(self.done("resume", folder, status=4).stderr, r"side\.exr: has changed since the run began")
        photo.write_bytes(kept)
        self.done("resume", folder, "--time-limit", "1s", "-q", status=75)

        # One that may only be read, by somebody for whom that holds.
        somebody = 65534 if os.geteuid() == 0 else None
        for path in (self.folder, self.own):
            path.chmod(0o755)
        for path in [folder, *folder.rglob("*")]:
            path.chmod(0o555 if path.is_dir() else 0o444)
        try:
            self.done("version", user=somebody)
        except PermissionError:
            self.skipTest("the program lies where nobody else may go")
        for words in (["resume", folder], ["report", folder], ["export", folder, "--to", "glb"], ["eval", folder]):
            self.assertRegex(self.done(*words, status=4, user=somebody).stderr, r"Permission denied")
        for path in [folder, *folder.rglob("*")]:
            path.chmod(0o755 if path.is_dir() else 0o644)

    def test_a_full_disk_behind_standard_output_is_an_error(self):
        for words in (["config", "show", self.config], ["version"], ["config", "schema"], ["help"], ["info", "--json"]):
            with open("/dev/full", "w") as full:
                result = subprocess.run([PATHFIT, *map(str, words)], stdout=full, stderr=subprocess.PIPE, text=True)
            self.assertEqual(result.returncode, 75, (words, result.stderr))
            self.assertRegex(result.stderr, "standard output cannot be written: the disk is full")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
