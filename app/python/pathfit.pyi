"""Path-space differentiable rendering and fits to photographs.

Scenes come from the configs of the program (configs/README.md lists their keys). Pictures are arrays of
float64 of shape (height, width, 4): red, green, blue of linear Rec.709, and coverage; the first row is the
top one. Parameters have the units of the configs and are neither scaled nor bounded. Samples are a function
of the seed: the same numbers give the same bits as the program, for any number of threads. Long calls let
other threads of Python run; one Scene must not be used by two at once. Arrays that come back own their numbers:
nothing else changes them.
"""
import builtins
import os
from typing import Any, Callable, Sequence

import numpy as np
import scipy.sparse

__version__: str

class ConfigError(ValueError):
    """All problems of a config, each with file:line:column, as the program prints them."""

class SceneError(ValueError):
    """A scene that cannot be rendered, or a name that it does not have."""

class IoError(OSError):
    """A file is missing, unreadable or malformed."""

class NumericalError(ArithmeticError):
    """A number that should be finite is not."""

class MemoryError(builtins.MemoryError):
    """A fit would take more memory than there is; refused before it begins."""

class Parameters:
    """Which numbers of a scene are meant, in which order."""

    def __len__(self) -> int:
        """How many numbers."""

    @property
    def groups(self) -> list[dict[str, Any]]:
        """One per name: `name`, `first` (index of its first number), `shape` (blocks, numbers of each): the
        values of group g are values[g["first"]:][:shape[0] * shape[1]].reshape(shape)."""

    def name_of(self, index: int) -> str:
        """'ball.vertices[17].y'"""

class Scene:
    """The scene of a config, its photos and stages."""

    def __init__(
        self, config: str | os.PathLike[str], overrides: dict[str, Any] = {}, threads: int = 0
    ) -> None:
        """`overrides` replaces values of the config: {"render.spp": 64}. threads: 0 = those of the config,
        else PATHFIT_THREADS, else all that may be used."""

    @staticmethod
    def from_string(
        text: str, folder: str | os.PathLike[str] = ".", overrides: dict[str, Any] = {}, threads: int = 0
    ) -> Scene:
        """The same of a config's text; what it names by relative paths begins in `folder`. Messages call it
        <string>."""

    @staticmethod
    def from_dict(
        config: dict[str, Any], folder: str | os.PathLike[str] = ".", overrides: dict[str, Any] = {}, threads: int = 0
    ) -> Scene:
        """The same of dicts, lists and numbers under the keys of a config; messages name what is wrong by its
        keys. Lists may be arrays: a mesh of one's own is
        {"scene": {"geometry": {"ball": {"mesh": {"vertices": positions, "triangles": triangles}, ...}}}} with
        positions of shape (n, 3) and triangles of shape (m, 3), counter-clockwise from outside. Vertices in the
        same place become one, unused ones go: parameters(["ball.vertices"]) counts what is left, in order."""

    @property
    def views(self) -> list[str]:
        """Names of the sensors or photos. A `view` below is one of them, or its index."""

    @property
    def messages(self) -> list[str]:
        """What was taken for granted, in sentences."""

    @property
    def warnings(self) -> list[str]:
        """What of the files is not used."""

    def photo(self, view: int | str) -> np.ndarray:
        """(height, width, 3), float32, linear Rec.709."""

    def mask(self, view: int | str) -> np.ndarray | None:
        """(height, width, 1), float32, 1 = object."""

    def parameters(self, names: Sequence[str]) -> Parameters:
        """`names` as under `unknowns` of a config: ["ball.vertices", "sky.texels"]."""

    def values(self, parameters: Parameters) -> np.ndarray:
        """A copy of their present values."""

    def set_values(self, parameters: Parameters, values: np.ndarray) -> None:
        """Changes the scene. SceneError, and nothing changed, if it could not be rendered. Takes float64 without
        a copy if it is contiguous."""

    def render(self, view: int | str, spp: int | None = None, seed: int | None = None) -> np.ndarray:
        """The picture; samples per pixel and seed are those of the config unless given."""

    def derivative(
        self, view: int | str, direction: str, spp: int | None = None, seed: int | None = None
    ) -> np.ndarray:
        """Derivative of the picture along `direction`, as `pathfit render --derivative` names it:
        'ball.vertices.x', 'light.intensity', 'floor.texels[5].r'; without a component all numbers alike.
        Samples of its boundaries and its form are found unless the config gives them, as there; those of
        jacobian and gradient are the config's or 8, the form is that of fits."""

    def jacobian(
        self, view: int | str, parameters: Parameters, spp: int | None = None, seed: int | None = None
    ) -> scipy.sparse.csr_matrix:
        """Derivative of picture.reshape(-1) by all parameters: float32, as fits keep it, with int32 indices where
        these suffice. Products with float64 are float64."""

    def gradient(
        self,
        view: int | str,
        parameters: Parameters,
        weights: np.ndarray,
        spp: int | None = None,
        seed: int | None = None,
    ) -> np.ndarray:
        """jacobian(...).T @ weights.reshape(-1) without the matrix; `weights` has the picture's shape. It is
        the gradient of a loss if `weights` is its derivative by the picture of other samples (another seed):
        with the same samples the product of their errors would be a bias."""

    def not_in_the_derivative(self, parameters: Parameters) -> list[str]:
        """What derivatives by these parameters leave out, one sentence each."""

    def fit(
        self,
        on_round: Callable[[dict[str, Any]], bool | None] | None = None,
        time_limit_s: float = 0.0,
        on_message: Callable[[str], bool | None] | None = None,
        on_warning: Callable[[str], bool | None] | None = None,
        on_stage: Callable[[dict[str, Any]], bool | None] | None = None,
        on_view: Callable[[str, str, np.ndarray, np.ndarray], bool | None] | None = None,
        checkpoints: str | os.PathLike[str] | None = None,
        resume: bool = False,
    ) -> dict[str, Any]:
        """Runs the stages of the config from the present state, which becomes that of the result. Refuses a start
        that cannot be fitted as the program does.

        `on_round` gets the figures of each round by their names in metrics.csv, `on_stage` those of the start and of
        each stage's end, `on_view` stage, view, its picture then and its photo at that size, `on_message` and
        `on_warning` sentences. The fit stops after the round in which one returns False, and ends with its
        exception: then the state stays what it was, and the checkpoints are the way on.

        `checkpoints` is a folder for the state after each round, new or empty unless `resume`: then the newest state
        there is continued, if there is one. A Scene that resumes must be what the fit began with.

        Returns `status` ('finished', 'stopped' or 'time limit'), `rounds` (of all sessions), `wall_s`, `stages`
        (figures), `standard_errors` by unknown, `messages` and `warnings`."""

    def write_meshes(self, folder: str | os.PathLike[str], format: str = "glb") -> list[os.PathLike[str]]:
        """One file per mesh, where their poses place them: glb, ply or obj."""
