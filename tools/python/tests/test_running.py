"""While it works: other threads, progress, Ctrl-C, warnings."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import midsurf
import pytest


def test_progress_is_told_in_the_calling_thread(fixtures: Path) -> None:
    told = []

    def progress(stage: str, done: int, expected: int) -> None:
        assert threading.current_thread() is threading.main_thread()
        told.append((stage, done, expected))

    midsurf.extract(fixtures / "bracket.obj", cell="0.5t", progress=progress)
    stages = list(dict.fromkeys(stage for stage, _, _ in told))
    assert stages == ["reading", "field", "trace", "mesh"]
    assert all(done <= expected for stage, done, expected in told if stage == "trace")


def test_an_exception_out_of_progress_ends_the_work(fixtures: Path) -> None:
    def progress(stage: str, done: int, expected: int) -> None:
        if stage == "trace":
            raise KeyError("enough")

    start = time.monotonic()
    with pytest.raises(KeyError, match="enough"):
        midsurf.extract(fixtures / "enclosure.obj", cell="0.3t", progress=progress)
    assert time.monotonic() - start < 20.0


def test_other_threads_run_meanwhile(fixtures: Path) -> None:
    ticks = 0
    over = threading.Event()

    def tick() -> None:
        nonlocal ticks
        while not over.wait(0.005):
            ticks += 1

    thread = threading.Thread(target=tick)
    thread.start()
    start = time.monotonic()
    try:
        midsurf.extract(fixtures / "bracket.obj", cell="0.5t")
    finally:
        took = time.monotonic() - start
        over.set()
        thread.join()
    # A lock held throughout would leave none but the first.
    assert ticks > 5 if took > 0.2 else took >= 0.0


@pytest.mark.parametrize(
    "work",
    [
        "midsurf.extract(part, cell='0.3t', progress=begun)",
        "midsurf.offset(part, 1.0, cell='0.15%', progress=begun)",
    ],
)
def test_ctrl_c_ends_the_work(fixtures: Path, work: str) -> None:
    script = f"""
import signal, sys, midsurf
# Work in the background of a shell is started with Ctrl-C ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)
part = sys.argv[1]
def begun(stage, done, expected):
    if stage in ("trace", "band"):
        print("begun", flush=True)
try:
    {work}
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
    command = [sys.executable, "-c", script, str(fixtures / "enclosure.obj")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            assert process.stdout.readline() == "begun\n"
            process.send_signal(signal.SIGINT)
            rest, _ = process.communicate(timeout=60.0)
        finally:
            process.kill()
    assert rest.splitlines()[-1] == "interrupted"


def test_what_is_odd_is_warned_of(fixtures: Path) -> None:
    with pytest.warns(midsurf.PartWarning, match="no triangle is tagged as coping") as told:
        mid = midsurf.extract(fixtures / "plate.obj", coping="none", cell="1t")
    assert "no_coping" in [warning.code for warning in mid.warnings]
    # It is told where the package was called.
    assert any(Path(warning.filename).name == Path(__file__).name for warning in told)


def test_extractions_run_side_by_side(fixtures: Path) -> None:
    results: list[midsurf.MidSurface] = []

    def work() -> None:
        results.append(midsurf.extract(fixtures / "tee.obj", cell="1t"))

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len({mid.vertices.tobytes() for mid in results}) == 1 and len(results) == 4
