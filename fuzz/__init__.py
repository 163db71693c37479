"""Throws random scenes, files and arguments at the `raylet` program and watches what becomes of them.

`python3 -m fuzz --help` tells how; `docs/fuzzing.md` tells what is made and what counts as fallen.
"""
