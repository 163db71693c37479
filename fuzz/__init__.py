"""Runs the `raylet` program with random scenes, files and arguments, and judges how each run ends.

`python3 -m fuzz --help` lists the options; `docs/fuzzing.md` says what is made and what counts as a failure.
"""
