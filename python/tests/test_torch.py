"""Gradients inside PyTorch."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT, hologram, noise, through_lens

import raylet
from raylet.linearised_system import LinearisedSystem

torch = pytest.importorskip("torch")
import raylet.torch  # noqa: E402

pytestmark = pytest.mark.torch


def phases(shape: tuple[int, int], dtype: object = None) -> object:
    return torch.tensor(noise(shape), dtype=dtype or torch.float64, requires_grad=True)


def test_gradcheck_of_phases_in_free_space() -> None:
    linearised = hologram(noise((4, 5)), pixels=(5, 4)).linearised("hologram")
    assert torch.autograd.gradcheck(lambda phase: raylet.torch.field(linearised, phase), (phases((4, 5)),))
    assert torch.autograd.gradcheck(lambda phase: raylet.torch.intensity(linearised, phase), (phases((4, 5)),))


def test_gradcheck_of_complex_transmissions() -> None:
    linearised = hologram(noise((3, 4)), pixels=(4, 3)).linearised("hologram")
    start = torch.tensor(0.7 * np.exp(1j * noise((3, 4))), requires_grad=True)
    assert torch.autograd.gradcheck(lambda t: raylet.torch.field(linearised, t), (start,))


def test_gradcheck_of_phases_and_parameters_through_a_lens() -> None:
    system = through_lens(noise((3, 4)), pixels=(4, 3))
    linearised = system.linearised("hologram", parameters=["element[1].radius_mm", "element[2].thickness_mm"])
    assert linearised.names == ("1/element[1].radius_mm", "element[2].thickness_mm")
    scale = torch.tensor([1e-3, 1e-2], dtype=torch.float64)
    start = torch.tensor(linearised.start)

    def field(phase: object, moved: object) -> object:
        return raylet.torch.field(linearised, phase, parameters=start + scale * moved)

    moved = torch.zeros(2, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(field, (phases((3, 4)), moved), eps=1e-5, atol=1e-4, rtol=1e-3)


def test_precision_follows_what_is_given() -> None:
    linearised = hologram(noise((4, 5))).linearised("hologram")
    double, single = phases((4, 5)), phases((4, 5), torch.float32)
    a, b = raylet.torch.field(linearised, double), raylet.torch.field(linearised, single)
    assert a.dtype == torch.complex128 and b.dtype == torch.complex64
    assert float((a - b).detach().abs().max() / a.detach().abs().max()) < 1e-5
    for field in (a, b):
        field.abs().square().sum().backward()
    assert single.grad.dtype == torch.float32
    assert torch.allclose(single.grad.double(), double.grad, rtol=1e-4, atol=1e-5 * float(double.grad.abs().max()))


def test_tensors_are_not_copied(monkeypatch: pytest.MonkeyPatch) -> None:
    """The library sees the tensor's memory, and the field is a tensor in the library's."""
    linearised, phase = hologram(noise((4, 5))).linearised("hologram"), phases((4, 5))
    seen = []

    def spy(self: LinearisedSystem, *pixels: np.ndarray, parameters: object = None) -> object:
        passage = forward(self, *pixels, parameters=parameters)
        seen.append((pixels[0].ctypes.data, passage.field.ctypes.data))
        return passage

    forward = LinearisedSystem.__call__
    monkeypatch.setattr(LinearisedSystem, "__call__", spy)
    field = raylet.torch.field(linearised, phase)
    assert seen == [(phase.data_ptr(), field.data_ptr())]


def test_two_losses_of_one_passage() -> None:
    linearised, phase = hologram(noise((4, 5))).linearised("hologram"), phases((4, 5))
    field = raylet.torch.field(linearised, phase)
    (first,) = torch.autograd.grad(field[3, 4].real, phase, retain_graph=True)
    (second,) = torch.autograd.grad(field[3, 4].imag, phase)
    # U depends on phase through e^{iφ}: the rows of the Jacobian differ.
    assert not torch.allclose(first, second)


def test_wrong_tensors_are_refused() -> None:
    linearised = hologram(noise((4, 5))).linearised("hologram")
    with pytest.raises(ValueError, match=r"shape \(5, 4\), expected \(4, 5\)"):
        raylet.torch.field(linearised, phases((5, 4)))
    with pytest.raises(TypeError, match="torch.int64"):
        raylet.torch.field(linearised, torch.zeros((4, 5), dtype=torch.int64))
    with pytest.raises(TypeError, match="expected 1"):
        raylet.torch.field(linearised)


def test_example_learns(monkeypatch: pytest.MonkeyPatch) -> None:
    """The element, the lens's curvature and the network of the example learn together."""
    monkeypatch.syspath_prepend(str(ROOT / "python" / "examples"))
    import learned_camera

    losses = learned_camera.train(5)
    assert np.mean(losses[-3:]) < 0.8 * losses[0]
