"""Gradient descent on a loss of one's own: own_loss.py CONFIG."""
import sys

import numpy as np
import pathfit

scene = pathfit.Scene(sys.argv[1])
target = {view: scene.render(view, spp=512, seed=100) for view in scene.views}

parameters = scene.parameters(["ball.translation", "paint.base_color"])
truth = scene.values(parameters)
values = truth + [0.15, -0.1, 0.05, -0.3, 0.2, 0.2]
step = np.array([0.02, 0.02, 0.02, 0.1, 0.1, 0.1])  # metres, and shares of light


def loss_and_gradient(values, seed):
    """Mean of log-cosh over pixels, and its gradient J^T w."""
    scene.set_values(parameters, values)
    loss, gradient = 0.0, np.zeros(len(parameters))
    for view in scene.views:
        error = (scene.render(view, spp=16, seed=2 * seed) - target[view]) / 0.1
        loss += 0.1 * np.mean(np.log(np.cosh(error)))
        weights = np.tanh(error) / error.size
        # Other samples than those of `weights`: the product of two errors of the same ones would be a bias.
        gradient += scene.gradient(view, parameters, weights, spp=16, seed=2 * seed + 1)
    return loss, gradient


mean, square = np.zeros_like(values), np.zeros_like(values)
for i in range(1, 81):  # Adam
    loss, gradient = loss_and_gradient(values, i)
    mean = 0.8 * mean + 0.2 * gradient
    square = 0.95 * square + 0.05 * gradient**2
    rate = step / (1 + (i / 30) ** 2)
    values = values - rate * (mean / (1 - 0.8**i)) / np.sqrt(square / (1 - 0.95**i) + 1e-12)
    values[3:] = values[3:].clip(0, 1)
    if i in (1, 20, 80):
        print(f"step {i}: loss {loss:.5f}, off by {abs(values - truth)[:3].max():.3f} m and {abs(values - truth)[3:].max():.3f} of colour")
assert abs(values - truth).max() < 0.05
