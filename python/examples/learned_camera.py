"""A camera learned end to end: a diffractive element, a curvature of its lens, and a small network that reconstructs.

    python python/examples/learned_camera.py [--steps N]

The scene is a row of point sources at infinity, bright or dark, one direction each. What the sensor sees of each
direction is the intensity behind a phase element and a real plano-convex lens; directions add incoherently. A network
of two layers is to find from the noisy, coarse sensor which sources shine. Element, curvature and network are trained
together by Adam: raylet gives the gradients of the optics, PyTorch those of the network.
"""

from __future__ import annotations

import argparse

import numpy as np
import torch

import raylet
import raylet.torch

PIXELS, PITCH_UM, SENSOR = 10, 20.0, (8, 8)
ANGLES_DEG = (-0.5, 0.0, 0.5)


def camera(angle_deg: float) -> raylet.System:
    """The optics for the light of one direction."""
    system = raylet.System(wavelength_um=0.6).plane_wave(angle_deg=(angle_deg, 0.0))
    width = PIXELS * PITCH_UM * 1e-3
    layer = raylet.pixels(pitch_um=PITCH_UM, phase=np.zeros((PIXELS, PIXELS)))
    system.add_doe(layer, aperture=raylet.rectangle(width, width), thickness_mm=1.0, name="element")
    system.add_surface(radius_mm=6.0, thickness_mm=1.5, glass="N-BK7", semi_aperture_mm=1.5)
    system.add_surface(semi_aperture_mm=1.5, thickness_mm=8.0)
    return system.add_sensor(pixels=SENSOR, pitch_um=40.0)


class Camera(torch.nn.Module):
    """The optics as a layer: brightness of each direction to the image on the sensor."""

    def __init__(self) -> None:
        super().__init__()
        path = "element[1].radius_mm"
        self.linearised = [camera(angle).linearised("element", parameters=[path]) for angle in ANGLES_DEG]
        self.phase = torch.nn.Parameter(0.1 * torch.randn(PIXELS, PIXELS, dtype=torch.float64))
        self.start = torch.tensor(self.linearised[0].start)
        self.bend = torch.nn.Parameter(torch.zeros(1, dtype=torch.float64))

    def forward(self, brightness: torch.Tensor) -> torch.Tensor:
        # One unit of `bend` is a percent of the curvature.
        parameters = self.start * (1.0 + 0.01 * self.bend)
        spots = [raylet.torch.intensity(system, self.phase, parameters=parameters) for system in self.linearised]
        scale = sum(spot.detach().sum() for spot in spots) / len(spots)
        return torch.einsum("bd,dyx->byx", brightness, torch.stack(spots) / scale)


def train(steps: int, seed: int = 0) -> list[float]:
    """The loss at each step."""
    torch.manual_seed(seed)
    optics = Camera()
    count = SENSOR[0] * SENSOR[1]
    network = torch.nn.Sequential(
        torch.nn.Linear(count, 32), torch.nn.ReLU(), torch.nn.Linear(32, len(ANGLES_DEG))
    ).double()
    groups = [{"params": optics.parameters(), "lr": 0.1}, {"params": network.parameters(), "lr": 3e-3}]
    optimizer = torch.optim.Adam(groups)
    losses = []
    for step in range(steps):
        shining = torch.randint(0, 2, (64, len(ANGLES_DEG))).double()
        image = optics(shining)
        noisy = image + 2e-3 * torch.randn_like(image)
        loss = torch.nn.functional.binary_cross_entropy_with_logits(network(100.0 * noisy.flatten(1)), shining)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        losses.append(float(loss.detach()))
        if step % 10 == 0:
            radius = 1.0 / float(optics.start * (1.0 + 0.01 * optics.bend.detach()))
            print(f"step {step}: loss {losses[-1]:.4f}, radius {radius:.3f} mm")
    return losses


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=60)
    history = train(parser.parse_args().steps)
    print(f"loss {history[0]:.3f} at first, {np.mean(history[-5:]):.3f} at last")
