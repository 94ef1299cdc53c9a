"""What the tests share: fixtures of the repository, and the command, where it was built."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
FIXTURES = ROOT / "fixtures"


@pytest.fixture(scope="session")
def fixtures() -> Path:
    return FIXTURES


@pytest.fixture(scope="session")
def command() -> str:
    """The program `midsurf`: of this repository, or on the path."""
    built = [ROOT / "target" / profile / "midsurf" for profile in ("debug", "release")]
    found = [str(file) for file in built if file.is_file()]
    program = shutil.which("midsurf")
    if not found and program is None:
        pytest.skip("the program midsurf is not built: `cargo build`")
    return found[0] if found else str(program)
