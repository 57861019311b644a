"""A picture, its derivative beside a finite difference, and a sparse Jacobian: derivatives.py CONFIG."""
import sys

import numpy as np
import pathfit

scene = pathfit.Scene(sys.argv[1])
picture = scene.render("left")  # red, green, blue of linear Rec.709, and coverage
print("views", scene.views, "picture", picture.shape, picture.dtype)


def tiles(image, size=6):
    """Sums over squares of pixels: noise and the steps of a moving border average out."""
    height, width, channels = image.shape
    return image.reshape(height // size, size, width // size, size, channels).sum(axis=(1, 3))


# The ball moves along x, and with it its outline and its shadow: the derivative knows both.
derivative = scene.derivative("left", "ball.translation.x", spp=256)
place = scene.parameters(["ball.translation"])
start = scene.values(place)
step = np.array([0.01, 0, 0])
pictures = []
for sign in (-0.5, 0.5):
    scene.set_values(place, start + sign * step)
    pictures.append(scene.render("left", spp=1024))
scene.set_values(place, start)
difference = (pictures[1] - pictures[0]) / step[0]
error = np.linalg.norm(tiles(derivative) - tiles(difference)) / np.linalg.norm(tiles(difference))
print(f"derivative image: off a finite difference by {100 * error:.0f} % of its norm")
assert error < 0.15

# All vertices and the paint at once: one row per channel of each pixel, one column per number.
parameters = scene.parameters(["ball.vertices", "paint.base_color"])
for group in parameters.groups:
    print(group["name"], group["shape"])
jacobian = scene.jacobian("left", parameters)
print(type(jacobian).__name__, jacobian.dtype, jacobian.shape, f"{100 * jacobian.nnz / np.prod(jacobian.shape):.1f} % filled")

# Moving all vertices is moving the ball.
along_x = np.zeros(len(parameters))
along_x[: 3 * parameters.groups[0]["shape"][0] : 3] = 1
same = (jacobian @ along_x).reshape(picture.shape)
apart = np.linalg.norm(tiles(same) - tiles(derivative)) / np.linalg.norm(tiles(derivative))
print(f"the sum of its columns: off the derivative image by {100 * apart:.0f} %")
assert apart < 0.15
