"""Checks the licences of all dependencies against the list in .deny.toml, offline.

For machines without cargo-deny. An expression passes if one side of each OR, and both sides of each AND, is allowed.
"""

import json
import subprocess
import sys
import tomllib


def allowed(expression: str, allow: set[str]) -> bool:
    """Whether an SPDX expression, nested in brackets or not, can be met."""
    # Before OR stood for it, packages wrote a slash.
    words = expression.replace("/", " OR ").replace("(", " ( ").replace(")", " ) ").split()

    def either(at: int) -> tuple[bool, int]:
        result, at = both(at)
        while at < len(words) and words[at] == "OR":
            other, at = both(at + 1)
            result = result or other
        return result, at

    def both(at: int) -> tuple[bool, int]:
        result, at = one(at)
        while at < len(words) and words[at] == "AND":
            other, at = one(at + 1)
            result = result and other
        return result, at

    def one(at: int) -> tuple[bool, int]:
        if words[at] == "(":
            result, at = either(at + 1)
            return result, at + 1
        name, at = words[at], at + 1
        if at < len(words) and words[at] == "WITH":
            name, at = f"{name} WITH {words[at + 1]}", at + 2
        return name in allow, at

    return either(0)[0]


def main() -> int:
    with open(".deny.toml", "rb") as file:
        allow = set(tomllib.load(file)["licenses"]["allow"])
    command = ["cargo", "metadata", "--format-version", "1", "--locked"]
    packages = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)["packages"]
    bad = [p for p in packages if not allowed(p["license"] or "none", allow)]
    for package in bad:
        print(f"{package['name']} {package['version']}: {package['license']}")
    print(f"licences of {len(packages)} packages, {len(bad)} of them not allowed")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
