#!/usr/bin/env python3
"""The page of `midsurf view` in a real browser: looks, turns, tags, saves, extracts,
cancels, takes a picture, and is closed to strangers.

    view_test.py [--binary target/debug/midsurf] [--pictures FOLDER]

Needs Chromium and ChromeDriver (Debian: apt-get install chromium chromium-driver),
and nothing from elsewhere: the browser is driven by the W3C WebDriver protocol.
"""
import argparse
import base64
import http.client
import json
import os
import pathlib
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parent.parent
FIXTURES = ROOT / "fixtures"
WAIT = 60
SIZE = (1280, 720)
ELEMENT = "element-6066-11e4-a52e-4f735466cecf"
CTRL, ESCAPE = "\ue009", "\ue00c"
BROWSER = [
    "--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist", "--hide-scrollbars", "--force-device-scale-factor=1", "--disable-dev-shm-usage",
]


class Browser:
    """A headless Chromium, as far as the tests need it."""

    def __init__(self, downloads):
        self.profile = tempfile.mkdtemp(prefix="midsurf-view-")
        port = free_port()
        self.driver = subprocess.Popen(
            ["chromedriver", f"--port={port}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.base = f"http://127.0.0.1:{port}"
        until(lambda: self.call("GET", "/status")["ready"], "chromedriver")
        options = {"args": [*BROWSER, f"--user-data-dir={self.profile}", f"--window-size={SIZE[0]},{SIZE[1]}"],
                   "prefs": {"download.default_directory": str(downloads)}}
        wanted = {"browserName": "chrome", "goog:chromeOptions": options, "unhandledPromptBehavior": "accept"}
        made = self.call("POST", "/session", {"capabilities": {"alwaysMatch": wanted}})
        self.session = f"/session/{made['sessionId']}"
        self.devtools("Emulation.setDeviceMetricsOverride", width=SIZE[0], height=SIZE[1], deviceScaleFactor=1, mobile=False)

    def call(self, method, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.base + path, data, {"Content-Type": "application/json"}, method=method)
        try:
            with urllib.request.urlopen(request, timeout=WAIT) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            raise RuntimeError(json.load(error)["value"]["message"]) from None
        except (ConnectionError, urllib.error.URLError):
            return {"ready": False}

    def post(self, path, **body):
        return self.call("POST", self.session + path, body)

    def devtools(self, command, **params):
        return self.post("/goog/cdp/execute", cmd=command, params=params)

    def open(self, url):
        self.post("/url", url=url)
        until(lambda: self.js("return document.documentElement.dataset.ready"), f"the page at {url}")
        ready = self.js("return document.documentElement.dataset.ready")
        check(ready == "yes", f"the page starts: {self.js('return document.getElementById(`message`).textContent')}")

    def js(self, script, *args):
        return self.post("/execute/sync", script=script, args=list(args))

    def click(self, selector):
        found = self.post("/element", using="css selector", value=selector)
        self.post(f"/element/{found[ELEMENT]}/click")

    def keys(self, text, held=None):
        actions = [{"type": "keyDown", "value": held}] if held else []
        for letter in text:
            actions += [{"type": "keyDown", "value": letter}, {"type": "keyUp", "value": letter}]
        actions += [{"type": "keyUp", "value": held}] if held else []
        self.post("/actions", actions=[{"type": "key", "id": "keys", "actions": actions}])

    def pointer(self, *points, press=True, button=0):
        """Moves to the first of some points on the canvas, presses, moves through the others, lets go."""
        canvas = self.post("/element", using="css selector", value="#canvas")
        box = self.js("const r = arguments[0].getBoundingClientRect(); return [r.width, r.height]", canvas)
        at = lambda p: {"type": "pointerMove", "duration": 30, "origin": canvas,
                        "x": round(p[0] - box[0] / 2), "y": round(p[1] - box[1] / 2)}
        actions = [at(points[0])]
        if press:
            actions += [{"type": "pointerDown", "button": button}, *map(at, points[1:]), {"type": "pointerUp", "button": button}]
        self.post("/actions", actions=[{"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": actions}])

    def picture(self):
        return base64.b64decode(self.call("GET", self.session + "/screenshot"))

    def errors(self):
        found = self.post("/se/log", type="browser")
        return [entry["message"] for entry in found if entry["level"] == "SEVERE"]

    def quit(self):
        try:
            self.call("DELETE", self.session)
        finally:
            self.driver.terminate()
            self.driver.wait()
            shutil.rmtree(self.profile, ignore_errors=True)


class View:
    """A running `midsurf view`."""

    def __init__(self, binary, *args):
        self.process = subprocess.Popen([binary, "view", *map(str, args), "--no-open"], stderr=subprocess.PIPE, text=True)
        for line in self.process.stderr:
            if line.startswith("http://"):
                self.url = line.strip()
                return
        raise RuntimeError("midsurf view gave no address")

    def seconds_of_work(self):
        with open(f"/proc/{self.process.pid}/stat") as file:
            fields = file.read().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def interrupt(self):
        self.process.send_signal(2)
        return self.process.wait(timeout=WAIT)


def free_port():
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


def until(ready, what):
    end = time.monotonic() + WAIT
    while not ready():
        if time.monotonic() > end:
            raise RuntimeError(f"waited {WAIT} s for {what}")
        time.sleep(0.05)


def check(holds, what):
    print(f"  {'ok  ' if holds else 'FAIL'} {what}")
    if not holds:
        raise AssertionError(what)


def coping(browser):
    return browser.js("return page.tagging.coping")


# The middle of the canvas's picture of a place of the part, in the file's coordinates.
PLACE = """const p = project(page.camera.matrices(arguments[1]).both, sub(arguments[0], page.part.facts.origin));
const c = document.getElementById('canvas');
return [(p.x + 1) / 2 * c.clientWidth, (1 - p.y) / 2 * c.clientHeight];"""


def spot(browser, *place):
    aspect = browser.js("const c = document.getElementById('canvas'); return c.clientWidth / c.clientHeight")
    return browser.js(PLACE, list(place), aspect)


def look_and_turn(browser, shot):
    check(browser.js("return page.part.triangles.length / 3") == 12, "the part is there")
    before = browser.js("return page.camera.yaw")
    browser.pointer((400, 300), (480, 330))
    check(browser.js("return page.camera.yaw") != before, "dragging turns")
    before = browser.js("return page.camera.distance")
    browser.click("[data-do='closer']")
    check(browser.js("return page.camera.distance") < before, "zooms without a wheel")
    browser.keys("0f")
    check(abs(browser.js("return page.camera.yaw") + 0.9) < 1e-9, "keys choose views")
    shot("part")


def tag_and_save(browser, folder, shot):
    """The plate is thin along y; its coping is at both ends of x and of z."""
    size = browser.js("return page.part.facts.size")
    low = browser.js("return sub(page.part.facts.origin, times(page.part.facts.size, 0.5))")

    def side(x, z):
        return spot(browser, low[0] + x * size[0], low[1] + 0.5 * size[1], low[2] + z * size[2])

    right, top, left, bottom = (1, 0.5), (0.5, 1), (0, 0.5), (0.5, 0)
    browser.keys("g")
    browser.pointer(side(*right), press=False)
    until(lambda: browser.js("return (page.tagging.shownPreview || []).length") == 2, "a preview")
    check(True, "a face to be clicked shows")
    browser.pointer(side(*right), side(*right))
    check(coping(browser) == 2, "a click marks the face, both triangles")
    browser.pointer(side(*top), side(*top))
    check(coping(browser) == 4, "another click, another face")
    browser.keys("z", held=CTRL)
    check(coping(browser) == 2, "undo")
    browser.keys("y", held=CTRL)
    check(coping(browser) == 4, "redo")
    browser.click("[data-mark='wall']")
    browser.pointer(side(*top), side(*top))
    check(coping(browser) == 2, "marking as wall takes back")
    browser.click("[data-mark='coping']")
    browser.keys("b")
    browser.pointer(side(0.45, 1), side(0.55, 1))
    check(coping(browser) > 2, "the brush paints")
    shot("brush")
    browser.keys("x")
    browser.js("document.getElementById('through').checked = true")
    browser.pointer((5, 5), (985, 655))
    check(coping(browser) == 12, "the box takes all that is in it")
    browser.click("[data-do='clear']")
    browser.keys("g")
    for faces, turned in [((right, top), 0), ((left, bottom), 1)]:
        browser.js("page.camera.turn(arguments[0] * Math.PI, -arguments[0]); page.render()", turned)
        for face in faces:
            browser.pointer(side(*face), side(*face))
    check(coping(browser) == 8, "four sides, from two views")
    shot("tagging")
    browser.keys("s", held=CTRL)
    until(lambda: not browser.js("return page.tagging.changed"), "the tags to be saved")
    text = (folder / "plate.coping.toml").read_text()
    check('format = "coping-tags"' in text and "[[coping]]" in text, "saved as an ordinary tag file")


def extract_and_look(browser, shot):
    browser.keys("v0f")
    until(lambda: browser.js("return page.part.facts.thickness"), "the thickness to be measured")
    browser.pointer((470, 340), press=False)
    until(lambda: "thickness" in browser.js("return document.getElementById('tip').textContent"), "the wall under the pointer")
    check(True, "thickness under the pointer before an extraction")
    browser.click("[data-do='extract']")
    until(lambda: browser.js("return !!page.mid && !work.running"), "the mid-surface")
    check(browser.js("return page.mid.facts.sheets.length") == 1, "one sheet")
    check(browser.js("return page.mid.facts.cracks.length") == 0, "no cracks")
    browser.pointer((490, 330), press=False)
    until(lambda: "thickness" in browser.js("return document.getElementById('tip').textContent"), "a measure under the pointer")
    tip = browser.js("return document.getElementById('tip').textContent")
    want = browser.js("return page.part.facts.thickness")
    check(abs(float(tip.split()[1]) - want) < 1e-3 * want, f"thickness under the pointer: {tip.split()[1]}")
    browser.keys("t")
    check(not browser.js("return document.getElementById('legend').hidden"), "a legend")
    shot("thickness")
    browser.keys("cw")
    shot("section")
    browser.keys("cccw")
    browser.keys("l")
    shot("other-theme")
    browser.keys("l")


def cancel_and_leave(browser, view):
    browser.js("document.getElementById('cell').min = -3; document.getElementById('cell').value = -3")
    browser.keys("e")
    until(lambda: browser.js("return document.getElementById('stage').textContent").startswith("trace"), "work")
    browser.keys(ESCAPE)
    until(lambda: not browser.js("return !!work.running"), "the end of it")
    check(quiet(view), "Esc stops the work")
    browser.keys("e")
    until(lambda: browser.js("return document.getElementById('stage').textContent").startswith("trace"), "work again")
    browser.post("/url", url="about:blank")
    check(quiet(view), "a page that went away leaves no work behind")


def quiet(view):
    """Whether the process falls still within some seconds."""
    for _ in range(40):
        before = view.seconds_of_work()
        time.sleep(0.5)
        if view.seconds_of_work() - before < 0.1:
            return True
    return False


def strangers(view):
    host, path = view.url.removeprefix("http://").split("/", 1)
    port = int(host.split(":")[1])

    def ask(method, path, body=None, **headers):
        link = http.client.HTTPConnection("127.0.0.1", port, timeout=WAIT)
        link.request(method, path, body, {k.replace("_", "-"): v for k, v in headers.items()})
        status = link.getresponse().status
        link.close()
        return status

    own = f"http://{host}"
    check(ask("GET", "/") == 404 and ask("GET", "/part") == 404, "no token, no page")
    check(ask("GET", f"/{path}part") == 200, "the token opens")
    check(ask("GET", f"/{path}part", Host="midsurf.example") == 403, "a foreign name is refused")
    check(ask("POST", f"/{path}save", b"x") == 403, "nothing is changed without an origin")
    check(ask("POST", f"/{path}save", b"x", Origin="http://midsurf.example") == 403, "nor from a foreign one")
    check(ask("POST", f"/{path}save", b"x", Origin=own) == 413, "a body of the wrong length is refused")
    check(ask("GET", f"/{path}../Cargo.toml") == 404, "no other files")
    check(ask("DELETE", f"/{path}part", Origin=own) == 404, "no other methods")


def one_file(browser, binary, folder, shot):
    page = folder / "mid.html"
    part = FIXTURES / "rib_grid"
    subprocess.run([binary, "extract", f"{part}.obj", "--coping", f"{part}.coping.txt", "-o", page, "--quiet"], check=True)
    browser.open(page.as_uri())
    check(browser.js("return page.mid.facts.sheets.length") > 1, "one file shows part and mid-surface by itself")
    check(browser.js("return document.getElementById('tag-section').hidden"), "and is for looking only")
    shot("one-file")
    browser.click("#list button")
    shot("one-sheet")
    browser.click("#list button")
    check(not browser.errors(), "no errors in the page")


def detected(browser, binary, shot):
    """What the detection found is there from the start; its doubts are questions."""
    view = View(binary, FIXTURES / "tee_filleted.obj")
    try:
        browser.open(view.url)
        found = coping(browser)
        check(found > 0, "detected coping faces are the start")
        browser.js("""page.doubts = [{ triangles: [0, 1], faces: 1, coping: false, reason: 'made up', at: [0, 0, 0], size: 1 },
            { triangles: [2], faces: 1, coping: false, reason: 'made up', at: [0, 0, 0], size: 1 }]; showLists();""")
        browser.click("#list button")
        shot("doubt")
        browser.keys("yn")
        check(browser.js("return page.doubts.map((doubt) => doubt.answer)") == ["coping", "wall"], "Y and N answer doubts")
        check(browser.js("return page.tagging.marks[0] & page.tagging.marks[1] & 1") == 1, "an answer marks the faces")
    finally:
        view.process.kill()
        view.process.wait()


def grid_plate(file, across=(230, 120), size=(60.0, 40.0, 2.0)):
    """A plate of more than a hundred thousand triangles, as binary STL."""
    (n, m), (x, y, z) = across, size
    triangles = []

    def face(at, columns, rows):
        for i in range(columns):
            for j in range(rows):
                a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
                triangles.extend([(a, b, c), (a, c, d)])

    px, py = (lambda i: x * i / n), (lambda j: y * j / m)
    face(lambda i, j: (px(i), py(j), z), n, m)
    face(lambda i, j: (px(j), py(i), 0.0), m, n)
    face(lambda i, j: (px(i), 0.0, z * j), n, 1)
    face(lambda i, j: (px(n - i), y, z * j), n, 1)
    face(lambda i, j: (0.0, py(m - i), z * j), m, 1)
    face(lambda i, j: (x, py(i), z * j), m, 1)
    with open(file, "wb") as out:
        out.write(struct.pack("<80xI", len(triangles)))
        for triangle in triangles:
            out.write(struct.pack("<12f2x", 0, 0, 0, *(value for corner in triangle for value in corner)))
    return len(triangles)


def large(browser, binary, folder, shot):
    """Where frames take long less is drawn as the view moves, and all once it rests."""
    count = grid_plate(folder / "large.stl")
    view = View(binary, folder / "large.stl")
    try:
        browser.open(view.url)
        move = "page.slow = true; page.camera.version++; page.draw(); return page.scene.drawn"
        check(0 < browser.js(move) < count / 4, "a large part moves as fewer triangles")
        shot("moving")
        until(lambda: browser.js("return page.scene.drawn") == count, "the whole part at rest")
        check(not browser.errors(), "no errors with a large part")
    finally:
        view.interrupt()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", default=ROOT / "target/debug/midsurf")
    parser.add_argument("--pictures", type=pathlib.Path, help="folder for pictures of the page")
    args = parser.parse_args()
    folder = pathlib.Path(tempfile.mkdtemp(prefix="midsurf-view-files-"))
    part = folder / "plate.obj"
    shutil.copy(FIXTURES / "plate.obj", part)
    browser = view = None

    def shot(name):
        data = browser.picture()
        check(data[:8] == b"\x89PNG\r\n\x1a\n" and len(data) > 10_000, f"a picture: {name}")
        if args.pictures:
            args.pictures.mkdir(parents=True, exist_ok=True)
            (args.pictures / f"{name}.png").write_bytes(data)

    try:
        view = View(args.binary, part, "--coping", "none")
        browser = Browser(folder)
        browser.open(view.url)
        for step in [lambda: look_and_turn(browser, shot), lambda: tag_and_save(browser, folder, shot),
                     lambda: extract_and_look(browser, shot)]:
            step()
        browser.click("[data-do='screenshot']")
        until(lambda: (folder / "plate.png").exists(), "the picture as a file")
        check(True, "the picture is saved as a file")
        check(not browser.errors(), "no errors in the page")
        cancel_and_leave(browser, view)
        strangers(view)
        detected(browser, args.binary, shot)
        large(browser, args.binary, folder, shot)
        one_file(browser, args.binary, folder, shot)
        check(view.interrupt() in (130, -2), "Ctrl-C ends it")
    except (AssertionError, RuntimeError) as error:
        print(f"failed: {error}")
        if browser and args.pictures:
            (args.pictures / "failed.png").write_bytes(browser.picture())
        return 1
    finally:
        if browser:
            browser.quit()
        if view and view.process.poll() is None:
            view.process.kill()
        shutil.rmtree(folder, ignore_errors=True)
    print("all passed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
