"""Looks at the report of a real fit with a browser, where there is one, and at a run that is served.

Usage: page_test.py PATHFIT SOURCE_DIR [FOLDER FOR SCREENSHOTS]. Unittest output; exits 1 if anything fails.
"""
import collections
import http.client
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

SHOTS = pathlib.Path(sys.argv.pop(3)) if len(sys.argv) > 3 else None
from program_test import DEMO, PATHFIT, QUICK, SOURCE, fit, run  # noqa: E402
from browser import CHROMIUM, Browser, pixels  # noqa: E402

CANVAS = "document.querySelector('.viewer canvas')"
# Of the whole page, which screenshots are taken of.
PLACE = """(() => { const box = document.querySelector('.viewer').getBoundingClientRect();
  return [box.x + scrollX, box.y + scrollY, box.width, box.height]; })()"""
SELECTS = "document.querySelectorAll('#model select')"
CHECKS = "document.querySelectorAll('#model .tools input')"


@unittest.skipUnless(CHROMIUM, "no Chromium")
class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="pathfit_page_"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        out = fit(cls.folder / "run", "--set", "unknowns.axe.vertices.mesh=keep")  # some of its vertices no pixel tells
        assert out.returncode == 0, out.stderr
        cls.page = cls.folder / "run" / "report.html"

    def shoot(self, browser, name, **options):
        return browser.screenshot(SHOTS / (name + ".png") if SHOTS else None, **options)

    def canvas(self, browser, name):
        """What the 3-D view shows: number of colours, share of the commonest one, and all of it as a checksum."""
        browser.eval("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        png = self.shoot(browser, name, clip=browser.eval(PLACE))
        rows = pixels(png)
        counts = collections.Counter(pixel for row in rows for pixel in row)
        return len(counts), counts.most_common(1)[0][1] / sum(counts.values()), hash(tuple(map(tuple, rows)))

    def choose(self, browser, which, value):
        browser.eval(f"(() => {{ const one = {SELECTS}[{which}]; one.value = '{value}'; "
                     "one.dispatchEvent(new Event('change')); })()")

    def check(self, browser, which):
        browser.eval(f"{CHECKS}[{which}].click()")

    def test_the_page_draws_and_asks_for_nothing(self):
        with Browser() as browser:
            browser.open(self.page.as_uri())
            self.assertTrue(browser.eval(f"{CANVAS} !== null"), "no 3-D view")
            self.shoot(browser, "page", whole=True)
            colors = self.canvas(browser, "fitted")
            self.assertGreater(colors[0], 300, "a shaded and coloured mesh")
            self.assertLess(colors[1], 0.98, "something before the background")
            self.choose(browser, 0, "start")
            start = self.canvas(browser, "start")
            self.assertNotEqual(start, colors)
            self.choose(browser, 0, "result")
            self.assertEqual(self.canvas(browser, "again"), colors, "the same picture again")
            seen = {}
            for value in browser.eval(f"[...{SELECTS}[1].options].map((one) => one.value)"):
                self.choose(browser, 1, value)
                seen[value] = self.canvas(browser, "colours_" + value)
            self.assertEqual(sorted(seen), ["color", "color_error", "normals", "photos", "position_error", "shape"], "colours are told, or not")
            self.assertNotEqual(seen["shape"], seen["color"])
            self.assertNotEqual(seen["photos"], seen["color"])
            self.choose(browser, 1, "color")
            self.check(browser, 0)
            self.assertNotEqual(self.canvas(browser, "without_shading"), colors)
            self.check(browser, 0)
            self.check(browser, 3)
            self.assertNotEqual(self.canvas(browser, "environment"), colors)
            self.check(browser, 3)
            self.assertEqual(self.canvas(browser, "again"), colors)
            self.look_through_a_photo(browser, colors)
            self.fade_and_enlarge(browser)
            self.assertEqual(browser.complaints, [])
            outside = [url for url in browser.requests if not url.startswith("data:") and url != self.page.as_uri()]
            self.assertEqual(outside, [])

    def look_through_a_photo(self, browser, colors):
        """A click at the frustum of a camera, and its photo over the mesh where the mesh is."""
        browser.eval("document.querySelector('#model').scrollIntoView()")
        self.shoot(browser, "model")
        self.choose(browser, 2, -2)
        outside = self.canvas(browser, "all_cameras")
        self.check(browser, 2)
        self.assertNotEqual(self.canvas(browser, "without_cameras"), outside)
        self.check(browser, 2)
        index = browser.eval("JSON.parse(document.getElementById('data').textContent).views[0].index")
        x, y = browser.eval("(() => { const box = document.querySelector('.viewer'); const at = box.getBoundingClientRect(); "
                            f"const [x, y] = box.view.screenOf({index}); return [at.x + x, at.y + y]; }})()")
        browser.pointer(("pressed", x, y), ("released", x, y))
        chosen = int(browser.eval(f"{SELECTS}[2].value"))
        self.assertGreaterEqual(chosen, 0, "a camera was clicked")
        self.canvas(browser, "clicked")
        self.choose(browser, 2, index)
        through = self.canvas(browser, "through")
        self.assertNotEqual(through, colors)
        browser.eval("(() => { const one = document.querySelector('.over input'); one.value = 1; "
                     "one.dispatchEvent(new Event('input')); })()")
        photo = self.canvas(browser, "through_photo")
        self.assertNotEqual(photo, through)
        browser.eval("(() => { const one = document.querySelector('.over input'); one.value = 0.5; "
                     "one.dispatchEvent(new Event('input')); })()")
        self.canvas(browser, "through_both")
        box = browser.eval("(() => { const box = document.querySelector('.viewer').getBoundingClientRect(); "
                           "return [box.x + box.width / 2, box.y + box.height / 2]; })()")
        browser.pointer(("pressed", *box), ("moved", box[0] + 60, box[1]), ("released", box[0] + 60, box[1]))
        self.assertEqual(browser.eval(f"{SELECTS}[2].value"), "-1", "turning leaves the photo")

    def fade_and_enlarge(self, browser):
        browser.eval("(() => { const one = document.querySelector('.fader input'); one.value = 1.5; "
                     "one.dispatchEvent(new Event('input')); one.scrollIntoView(); })()")
        self.assertEqual(browser.eval("[...document.querySelectorAll('.zoom img')].map((one) => one.alt)"),
                         ["rendering", "difference"])
        self.shoot(browser, "fader")
        ticks = "[...document.querySelectorAll('#curves .plot')[0].querySelectorAll('.tick')].map((t) => t.textContent).join()"
        whole = browser.eval(ticks)
        browser.eval("document.querySelector('#curves .plot svg').scrollIntoView({block: 'center'})")
        x, y, width = browser.eval("(() => { const b = document.querySelector('#curves .plot svg').getBoundingClientRect(); "
                                   "return [b.x, b.y + b.height / 2, b.width]; })()")
        ends = (x + 0.4 * width, x + 0.9 * width)
        browser.pointer(("pressed", ends[0], y), ("moved", ends[1], y), ("released", ends[1], y))
        self.assertNotEqual(browser.eval(ticks), whole)
        self.shoot(browser, "enlarged")
        browser.eval("document.querySelector('#curves .plot svg').dispatchEvent(new MouseEvent('dblclick'))")
        self.assertEqual(browser.eval(ticks), whole)

    def test_without_webgl_the_rest_works(self):
        with Browser(webgl=False) as browser:
            browser.open(self.page.as_uri())
            self.assertIn("WebGL is off or missing", browser.eval("document.querySelector('.viewer').textContent"))
            self.assertGreater(browser.eval("document.querySelectorAll('#curves svg').length"), 5)
            self.fade_and_enlarge(browser)
            self.shoot(browser, "without_webgl")
            self.assertEqual(browser.complaints, [])

    def test_the_page_is_small(self):
        pictures = sum(map(len, re.findall(r'"data:image/[^"]*"', self.page.read_text())))
        self.assertLess(self.page.stat().st_size - pictures, 3e6)


@unittest.skipUnless(CHROMIUM, "no Chromium")
class CheckPage(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="pathfit_check_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def look(self, config, name, *more):
        """The page of a check in a browser, which complained of nothing and asked for nothing; and its answer."""
        page = self.folder / (name + ".html")
        out = run("check", config, "-o", page, "--json", *more)
        self.assertEqual(out.returncode, 0, out.stderr)
        answer = json.loads(out.stdout)
        self.assertEqual(answer["page"], str(page))
        browser = Browser()
        self.addCleanup(browser.__exit__, None, None, None)
        browser.open(page.as_uri())
        browser.screenshot(SHOTS / (name + ".png") if SHOTS else None, whole=True)
        self.assertEqual(browser.complaints, [])
        self.assertEqual([url for url in browser.requests if not url.startswith("data:") and url != page.as_uri()], [])
        self.assertEqual(browser.eval("document.querySelectorAll('.checked image').length"), answer["views"])
        self.assertTrue(browser.eval(f"{CANVAS} !== null"), "no 3-D view")
        return browser, answer

    def test_the_start_over_every_photo(self):
        browser, answer = self.look(DEMO, "check_demo", *QUICK)
        self.assertEqual(browser.eval("document.querySelector('.badge').textContent"), "no objection")
        self.assertEqual(len(answer["stages"]), 2)
        for stage in answer["stages"]:
            self.assertGreaterEqual(stage["most_s"], stage["likely_s"])
            self.assertGreater(stage["likely_s"], stage["first_round_s"])
        box = browser.eval("(() => { const one = document.querySelector('.checked svg'); one.scrollIntoView(); "
                           "const at = one.getBoundingClientRect(); return [at.x + scrollX, at.y + scrollY, at.width, at.height]; })()")
        with_outline = browser.screenshot(clip=box)
        # An outline of the start that is drawn is orange somewhere, and is gone when it is switched off.
        orange = [p for row in pixels(with_outline) for p in row if p[0] > 200 and 70 < p[1] < 170 and p[2] < 90]
        self.assertGreater(len(orange), 50)
        browser.eval("document.querySelector('.over-outline input').click()")
        self.assertNotEqual(browser.screenshot(clip=box), with_outline)
        browser.eval("document.querySelector('.checked svg').dispatchEvent(new MouseEvent('click'))")
        self.assertGreater(browser.eval("document.querySelector('.checked svg').getBoundingClientRect().width"), 2 * box[2])
        browser.screenshot(SHOTS / "check_enlarged.png" if SHOTS else None)
        self.assertEqual(browser.complaints, [])

    def test_lamps_and_warnings(self):
        cat = SOURCE / "configs" / "tutorials" / "photometric_stereo" / "cat.yaml"
        browser, answer = self.look(cat, "check_cat", "--set", "input.max_size_px=96", "--set", "input.masks.invert=true")
        self.assertEqual(browser.eval("document.querySelectorAll('.warnings li').length"), len(answer["warnings"]))
        self.assertGreater(len(answer["warnings"]), 0)
        # One lamp shines in each photo.
        self.assertEqual(browser.eval("[...document.querySelectorAll('.checked')].map((one) => one.querySelectorAll('text.ray').length)"),
                         [1] * 12)

    def test_where_the_page_goes(self):
        quick = ["--set", "input.max_size_px=64", *QUICK]
        out = run("check", DEMO, *quick, cwd=self.folder)
        self.assertEqual(out.returncode, 0, out.stderr)
        self.assertIn(f"The start over every photo: {self.folder}/check.html", out.stdout)
        self.assertTrue((self.folder / "check.html").is_file())
        missing = run("check", DEMO, *quick, "-o", self.folder / "no" / "such" / "page.html")
        self.assertEqual(missing.returncode, 4, missing.stderr)
        self.assertIn("page.html", missing.stderr)


class Serve(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="pathfit_serve_"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        out = fit(cls.folder / "run", "--stop-after", "light")
        assert out.returncode == 0, out.stderr

    def serve(self, folder, *more):
        """The process and its port."""
        process = subprocess.Popen([PATHFIT, "serve", folder, "--port", "0", "--json", "-q", *more], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        answer = json.loads("".join(iter(process.stdout.readline, "}\n")) + "}")
        self.assertEqual((answer["schema"], answer["run"]), ("pathfit-serve-1", str(folder)))
        return process, int(re.fullmatch(r"http://127\.0\.0\.1:(\d+)/", answer["url"])[1])

    @staticmethod
    def get(port, path, **headers):
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
        connection.request("GET", path, headers={"Host": "localhost", **headers})
        answer = connection.getresponse()
        return answer.status, answer.read(), answer.headers

    def test_the_page_of_a_run_and_nothing_else(self):
        process, port = self.serve(self.folder / "run")
        status, page, headers = self.get(port, "/")
        self.assertEqual(status, 200)
        self.assertIn("connect-src 'self'", page.decode())
        self.assertEqual(headers["Content-Type"], "text/html; charset=utf-8")
        status, text, headers = self.get(port, "/data.json")
        data = json.loads(text)
        self.assertEqual((status, data["status"], data["run_path"]), (200, "finished", str(self.folder / "run")))
        self.assertEqual(self.get(port, "/data.json", **{"If-None-Match": headers["ETag"]})[:2], (304, b""))
        # A longer history is news.
        history = self.folder / "run" / "history.json"
        os.utime(history, ns=(1, 1))
        self.assertEqual(self.get(port, "/data.json", **{"If-None-Match": headers["ETag"]})[0], 200)
        for path in ("/run.json", "/../run.json", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "/data.json/../run.json",
                     "/images/", "/" + "a" * 20000):
            self.assertIn(self.get(port, path)[0], (400, 404, 414), path)
        self.assertEqual(self.get(port, "/data.json", Host="example.org")[0], 403, "another name for this machine")
        listening = [line.split()[1] for line in pathlib.Path("/proc/net/tcp").read_text().splitlines()[1:]
                     if line.split()[3] == "0A"]
        self.assertIn(f"0100007F:{port:04X}", listening)
        self.assertNotIn(f"00000000:{port:04X}", listening)
        taken = run("serve", self.folder / "run", "--port", port)
        self.assertEqual(taken.returncode, 4, taken.stderr)
        self.assertIn(f"127.0.0.1:{port} cannot be served: another program uses this port", taken.stderr)
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(20), 0)

    def test_ends_on_sigterm_and_refuses_what_is_no_run(self):
        process, port = self.serve(self.folder / "run")
        waiting = http.client.HTTPConnection("127.0.0.1", port)
        waiting.connect()  # and asks for nothing
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(20), 0)
        (self.folder / "empty").mkdir()
        self.assertEqual(run("serve", self.folder / "empty").returncode, 4)
        self.assertEqual(run("serve", self.folder / "run", "--port", "70000").returncode, 2)

    def test_damaged_files_are_an_answer(self):
        shutil.copytree(self.folder / "run", self.folder / "damaged")
        process, port = self.serve(self.folder / "damaged")
        (self.folder / "damaged" / "history.json").write_text("{")
        status, text, _ = self.get(port, "/data.json")
        self.assertEqual(status, 500)
        self.assertIn("history.json", text.decode())
        self.assertIsNone(process.poll())

    @unittest.skipUnless(CHROMIUM, "no Chromium")
    def test_the_page_follows_a_fit(self):
        folder = self.folder / "followed"
        fitting = subprocess.Popen([PATHFIT, "fit", DEMO, "-o", folder, "-q", *QUICK], stdout=subprocess.DEVNULL)
        self.addCleanup(fitting.wait)
        self.addCleanup(fitting.kill)
        while not (folder / "run.json").exists():
            time.sleep(0.05)
            self.assertIsNone(fitting.poll())
        fitting.send_signal(signal.SIGSTOP)  # until the browser is there, however long it takes
        serving, port = self.serve(folder)
        with Browser() as browser:
            browser.open(f"http://127.0.0.1:{port}/")
            badge = "document.querySelector('.badge').textContent"
            self.assertEqual(browser.eval(badge), "running")
            fitting.send_signal(signal.SIGCONT)
            browser.wait("document.querySelector('.viewer canvas') !== null", 300)
            browser.eval("(() => { const one = document.querySelectorAll('#model select')[1]; one.value = 'shape'; "
                         "one.dispatchEvent(new Event('change')); })()")
            browser.wait(f"{badge} === 'finished'", 300)
            self.assertEqual(fitting.wait(60), 0)
            self.assertEqual(browser.eval("document.querySelectorAll('#stages tbody tr').length"), 3)
            self.assertEqual(browser.eval("document.querySelectorAll('.viewer canvas').length"), 1)
            self.assertEqual(browser.eval("document.querySelectorAll('#model select')[1].value"), "shape", "is kept")
            self.assertEqual(browser.complaints, [])
            self.assertEqual({url.rsplit("/", 1)[0] for url in browser.requests if not url.startswith("data:")},
                             {f"http://127.0.0.1:{port}"})
            serving.send_signal(signal.SIGINT)
            serving.wait(20)
            browser.wait("document.getElementById('live')?.textContent.includes('does not answer')")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
