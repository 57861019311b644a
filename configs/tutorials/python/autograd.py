"""Pictures as a function that PyTorch differentiates: autograd.py CONFIG.

`Pictures` needs torch; without it this says so and leaves with status 0.
"""
import itertools
import sys

import numpy as np
import pathfit

try:
    import torch
except ImportError:
    torch = None


class Rendering:
    """Picture and gradient of a scene's view by parameters, as autograd wants them: arrays in, arrays out.

    Forward and backward take samples of their own: those of one would correlate the loss with its derivative."""

    def __init__(self, scene, names, spp=None):
        self.scene, self.spp = scene, spp
        self.parameters = scene.parameters(names)
        self.seeds = itertools.count(1)

    def values(self):
        return self.scene.values(self.parameters)

    def forward(self, values, view):
        self.scene.set_values(self.parameters, values)
        return self.scene.render(view, self.spp, seed=next(self.seeds))

    def backward(self, values, view, weights):
        self.scene.set_values(self.parameters, values)
        return self.scene.gradient(view, self.parameters, np.ascontiguousarray(weights), self.spp, seed=next(self.seeds))


if torch:

    class Pictures(torch.autograd.Function):
        """Pictures.apply(values, rendering, view): (height, width, 4), float64."""

        @staticmethod
        def forward(ctx, values, rendering, view):
            ctx.save_for_backward(values)
            ctx.rendering, ctx.view = rendering, view
            return torch.from_numpy(rendering.forward(values.detach().numpy(), view))

        @staticmethod
        def backward(ctx, weights):
            (values,) = ctx.saved_tensors
            gradient = ctx.rendering.backward(values.detach().numpy(), ctx.view, weights.numpy())
            return torch.from_numpy(gradient), None, None


def main(config):
    if torch is None:
        print("SKIPPED: torch is not installed (Debian: python3-torch), so nothing was differentiated by it")
        return
    scene = pathfit.Scene(config)
    target = {view: torch.from_numpy(scene.render(view, spp=512, seed=100)) for view in scene.views}
    rendering = Rendering(scene, ["paint.base_color", "lamp.position"], spp=32)
    truth = rendering.values()
    values = torch.tensor(truth + [-0.2, 0.2, 0.2, 0.2, -0.2, 0.2], requires_grad=True)
    optimizer = torch.optim.Adam([values], lr=0.03)
    for i in range(100):
        optimizer.zero_grad()
        loss = sum(((Pictures.apply(values, rendering, view) - target[view]) ** 2).mean() for view in target)
        loss.backward()
        optimizer.step()
        if i % 33 == 0:
            print(f"step {i}: loss {loss.item():.2e}")
    print("colour off by", np.abs(values.detach().numpy() - truth)[:3].max().round(3))
    assert np.abs(values.detach().numpy() - truth)[:3].max() < 0.05


if __name__ == "__main__":
    main(sys.argv[1])
