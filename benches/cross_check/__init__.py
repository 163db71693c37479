"""Random systems by whole fields, beamlets and local bands, side by side.

| module | what it holds |
| --- | --- |
| `elements` | Random layers and apertures |
| `systems` | Random systems of them |
| `comparison` | One system by several methods |
| `page` | `docs/cross_check.md` |
"""
