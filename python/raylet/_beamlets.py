"""Beamlets from Jacobians, written once for NumPy arrays and torch tensors."""

from __future__ import annotations

from typing import Any


def beamlets(xp: Any, k: float, jacobian: Any, window: Any, cosine: Any, along: Any, root_like: Any) -> tuple[Any, Any]:
    """Amplitudes (rays,) and curvatures (rays, 3) of beamlets: G = (C + Dq₀)(A + Bq₀)⁻¹ with q₀ = iW/k, and
    det(A + Bq₀)^{−1/2} √(cos/cos′), of the two roots the one near `root_like`."""
    W = xp.stack([window[:, [0, 1]], window[:, [1, 2]]], 1)
    A, B = jacobian[:, :2, :2], jacobian[:, :2, 2:]
    C, D = jacobian[:, 2:, :2], jacobian[:, 2:, 2:]
    M, N = A + (1j / k) * (B @ W), C + (1j / k) * (D @ W)
    a, b, c, d = M[:, 0, 0], M[:, 0, 1], M[:, 1, 0], M[:, 1, 1]
    det = a * d - b * c
    xx = (N[:, 0, 0] * d - N[:, 0, 1] * c) / det
    xy = (N[:, 0, 1] * a - N[:, 0, 0] * b) / det
    yx = (N[:, 1, 0] * d - N[:, 1, 1] * c) / det
    yy = (N[:, 1, 1] * a - N[:, 1, 0] * b) / det
    root = 1.0 / xp.sqrt(det) * xp.sqrt(cosine / xp.abs(along))
    flipped = (root * root_like.conj()).real < 0.0
    root = xp.where(flipped, -root, root)
    return root, xp.stack([xx, 0.5 * (xy + yx), yy], 1)
