"""Drives a headless Chromium by its debugging pipe: what a page asks for, what it complains of, and what it draws."""
import base64
import io
import json
import os
import shutil
import signal
import subprocess
import tempfile
import threading
import time

from PIL import Image

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-headless-shell")


class Browser:
    """One tab. `requests` and `complaints` grow while it lives."""

    def __init__(self, webgl=True, size=(1280, 1000)):
        self.profile = tempfile.mkdtemp(prefix="pathfit_browser_")
        to_browser, self.to = os.pipe()
        self.back, from_browser = os.pipe()
        gl = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"] if webgl else ["--disable-3d-apis"]
        words = [CHROMIUM, "--headless=new", "--no-sandbox", "--remote-debugging-pipe", "--no-first-run", *gl,
                 f"--user-data-dir={self.profile}", "--disable-background-networking", "--disable-component-update",
                 f"--window-size={size[0]},{size[1]}", "--hide-scrollbars", "--force-device-scale-factor=1", "about:blank"]
        # The pipe's ends are descriptors 3 and 4 of the browser.
        self.process = subprocess.Popen(
            ["bash", "-c", f'exec "$@" 3<&{to_browser} 4>&{from_browser}', "-", *words],
            pass_fds=(to_browser, from_browser), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        os.close(to_browser)
        os.close(from_browser)
        self.answers, self.requests, self.complaints, self.loads = {}, [], [], 0
        self.lock, self.number, self.session = threading.Condition(), 0, None
        threading.Thread(target=self.listen, daemon=True).start()
        tab = self.send("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.send("Target.attachToTarget", targetId=tab, flatten=True)["sessionId"]
        for domain in ("Page", "Network", "Runtime", "Log"):
            self.send(domain + ".enable")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        os.close(self.to)
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            pass
        try:
            os.killpg(self.process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        self.process.wait()
        shutil.rmtree(self.profile, ignore_errors=True)

    def listen(self):
        rest = b""
        while piece := os.read(self.back, 1 << 16):
            *messages, rest = (rest + piece).split(b"\0")
            for message in map(json.loads, messages):
                with self.lock:
                    self.hear(message)
                    self.lock.notify_all()
        with self.lock:
            self.answers[None] = True
            self.lock.notify_all()

    def hear(self, message):
        method, given = message.get("method"), message.get("params")
        if "id" in message:
            self.answers[message["id"]] = message
        elif method == "Network.requestWillBeSent":
            self.requests.append(given["request"]["url"])
        elif method == "Page.loadEventFired":
            self.loads += 1
        elif method == "Runtime.consoleAPICalled" and given["type"] in ("error", "warning", "assert"):
            self.complaints.append(" ".join(str(word.get("value", word.get("description"))) for word in given["args"]))
        elif method == "Runtime.exceptionThrown":
            self.complaints.append(json.dumps(given["exceptionDetails"]))
        elif method == "Log.entryAdded" and given["entry"]["level"] in ("error", "warning"):
            self.complaints.append(given["entry"]["text"])

    def send(self, method, **params):
        with self.lock:
            self.number += 1
            number = self.number
            message = {"id": number, "method": method, "params": params}
            if self.session:
                message["sessionId"] = self.session
            os.write(self.to, json.dumps(message).encode() + b"\0")
            self.lock.wait_for(lambda: number in self.answers or None in self.answers, 120)
            answer = self.answers.pop(number)
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']}")
        return answer["result"]

    def open(self, url):
        loads = self.loads
        self.send("Page.navigate", url=str(url))
        with self.lock:
            assert self.lock.wait_for(lambda: self.loads > loads, 120), f"{url} does not load"

    def eval(self, text):
        """Value of an expression in the page, or of what it promises."""
        result = self.send("Runtime.evaluate", expression=text, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise RuntimeError(json.dumps(result["exceptionDetails"]))
        return result["result"].get("value")

    def wait(self, text, seconds=60):
        end = time.monotonic() + seconds
        while not self.eval(text):
            assert time.monotonic() < end, f"never true: {text}"
            time.sleep(0.1)

    def pointer(self, *events):
        """(kind, x, y) with kinds pressed, moved and released, in pixels of the window."""
        for kind, x, y in events:
            self.send("Input.dispatchMouseEvent", type="mouse" + kind.capitalize(), x=x, y=y, button="left", clickCount=1,
                      buttons=0 if kind == "released" else 1)

    def screenshot(self, path=None, clip=None, whole=False):
        """PNG bytes of the window, of a part (x, y, width, height) of the page, or of the whole page."""
        more = {"captureBeyondViewport": True} if whole or clip else {}
        if clip:
            more["clip"] = dict(zip(("x", "y", "width", "height"), clip), scale=1)
        if whole:
            size = self.send("Page.getLayoutMetrics")["cssContentSize"]
            more["clip"] = {"x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1}
        png = base64.b64decode(self.send("Page.captureScreenshot", format="png", **more)["data"])
        if path:
            path.write_bytes(png)
        return png


def pixels(png):
    """Rows of (r, g, b), or (gray,), of a PNG file's bytes."""
    image = Image.open(io.BytesIO(png))
    if image.mode != "L":
        image = image.convert("RGB")
    values = [(value,) for value in image.getdata()] if image.mode == "L" else list(image.getdata())
    return [values[i:i + image.width] for i in range(0, len(values), image.width)]
