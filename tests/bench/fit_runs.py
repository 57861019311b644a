"""Photos, runs and what they found: what fit_duels.py and random_fits.py share. Standard library only."""
import array
import csv
import json
import math
import os
import struct
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

POLL_S = 0.005
TICKS = os.sysconf("SC_CLK_TCK")

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from run_state import from_cbor  # noqa: E402


# Cameras ---------------------------------------------------------------------------------------------------------------


def normalised(v):
    length = math.sqrt(sum(x * x for x in v))
    return [x / length for x in v]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def look_at(origin, target, up=(0, 1, 0)):
    """Columns of world_from_camera: x right, y up, looking along -z."""
    z = normalised([o - t for o, t in zip(origin, target)])
    x = normalised(cross(up, z))
    return [x, cross(z, x), z, list(origin)]


def write_transforms(path, cameras):
    """`cameras`: dicts with file, size, focal and columns (of look_at)."""
    frames = []
    for c in cameras:
        x, y, z, origin = c["columns"]
        frames.append({"file_path": c["file"], "w": c["size"][0], "h": c["size"][1], "fl_x": c["focal"], "fl_y": c["focal"],
                       "cx": c["size"][0] / 2, "cy": c["size"][1] / 2,
                       "transform_matrix": [[x[i], y[i], z[i], origin[i]] for i in range(3)] + [[0, 0, 0, 1]]})
    Path(path).write_text(json.dumps({"camera_model": "PINHOLE", "frames": frames}, indent=1))


# Rotations -------------------------------------------------------------------------------------------------------------


def rotation_matrix(vector):
    """Of a rotation vector in radians; rows."""
    angle = math.sqrt(sum(v * v for v in vector))
    if angle == 0.0:
        return [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    x, y, z = (v / angle for v in vector)
    c, s = math.cos(angle), math.sin(angle)
    return [[c + x * x * (1 - c), x * y * (1 - c) - z * s, x * z * (1 - c) + y * s],
            [y * x * (1 - c) + z * s, c + y * y * (1 - c), y * z * (1 - c) - x * s],
            [z * x * (1 - c) - y * s, z * y * (1 - c) + x * s, c + z * z * (1 - c)]]


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def rotation_angle(matrix):
    """In radians; accurate near 0 too."""
    sine = 0.5 * math.sqrt((matrix[2][1] - matrix[1][2]) ** 2 + (matrix[0][2] - matrix[2][0]) ** 2 + (matrix[1][0] - matrix[0][1]) ** 2)
    return math.atan2(sine, 0.5 * (matrix[0][0] + matrix[1][1] + matrix[2][2] - 1.0))


def rotation_vector(matrix):
    """Of a rotation by less than pi."""
    axis = [matrix[2][1] - matrix[1][2], matrix[0][2] - matrix[2][0], matrix[1][0] - matrix[0][1]]
    length = math.sqrt(sum(x * x for x in axis))
    angle = rotation_angle(matrix)
    return [x / length * angle for x in axis] if length > 0.0 else [0.0, 0.0, 0.0]


# Runs ------------------------------------------------------------------------------------------------------------------


@dataclass
class RoundState:
    """What a checkpoint holds of the scene after a round."""
    step: int
    wall_s: float  # of the fit so far, reports included
    user_s: float  # of the process so far
    values: dict = field(repr=False)  # name of an unknown -> its numbers; absent: as at the start
    shapes: dict = field(repr=False)  # of meshes that have other triangles than at the start


@dataclass
class Run:
    status: int  # of the program; None: it had to be killed
    wall_s: float
    user_s: float
    messages: str
    rounds: list  # of RoundState


def read_state(path):
    """The scene that a checkpoint holds; its numbers are little-endian in the file."""
    state = from_cbor(from_cbor(Path(path).read_bytes())[0]["payload"])[0]

    def doubles(index):
        return list(struct.unpack(f"<{len(state['arrays'][index]) // 8}d", state["arrays"][index]))

    scene = state["scene"]
    values = {name: doubles(index) for name, index in scene["values"].items()}
    shapes = {}
    for name, shape in scene["shapes"].items():
        if "triangles" in shape:
            triangles = array.array("i", state["arrays"][shape["triangles"]])
            shapes[name] = (doubles(shape["positions"]), list(triangles))
    return state["step"], state["wall_s"], values, shapes


def user_seconds(pid):
    """Of a process and its ended children so far; 0 when it is gone."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return int(fields[11]) / TICKS


def pinned(cores):
    """To run in the child: only the first `cores` of this process's cores."""
    if not cores:
        return None
    chosen = sorted(os.sched_getaffinity(0))[:cores]
    return lambda: os.sched_setaffinity(0, chosen)


class StateWatcher:
    """Reads every checkpoint of a run before the program removes it."""

    def __init__(self, folder):
        self.folder, self.seen, self.rounds = Path(folder), set(), []

    def poll(self, user_s):
        try:
            names = sorted(n for n in os.listdir(self.folder) if n.startswith("state_") and n.endswith(".cbor") and n not in self.seen)
        except OSError:
            return
        for name in names:
            self.seen.add(name)
            try:
                step, wall_s, values, shapes = read_state(self.folder / name)
            except OSError:
                continue
            # The last state of a stage has the step of its last round and what the stage keeps.
            self.rounds.append(RoundState(step, wall_s, user_s, values, shapes))


def run_fit(pathfit, config, folder, more=(), cores=0, timeout_s=None):
    """Runs `pathfit fit` and keeps the parameters after every round; after `timeout_s` it is killed."""
    command = [str(pathfit), "fit", str(config), "-o", str(folder), "--progress", "none", "-q", *map(str, more)]
    watcher = StateWatcher(Path(folder) / "checkpoints")
    started = time.monotonic()
    messages = Path(str(folder) + ".messages")
    messages.parent.mkdir(parents=True, exist_ok=True)
    with open(messages, "wb") as file:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=file, preexec_fn=pinned(cores))
        timed_out = False
        while True:
            user_s = user_seconds(process.pid)
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            watcher.poll(user_s)
            if pid:
                break
            if timeout_s and not timed_out and time.monotonic() - started > timeout_s:
                timed_out = True
                process.kill()
            time.sleep(POLL_S)
    process.returncode = os.waitstatus_to_exitcode(status)
    text = messages.read_text(errors="replace")
    messages.unlink()
    return Run(None if timed_out else process.returncode, time.monotonic() - started, usage.ru_utime, text, watcher.rounds)


def synth(pathfit, config, folder, gaussian=0.0, shot=0.0, copies=0):
    """Photos of the config's scene with noise, in folder/photos (of copies: folder/N/photos)."""
    more = ["--noise", repr(gaussian), "--shot-noise", repr(shot), *(["--copies", copies] if copies else [])]
    done = subprocess.run([str(pathfit), "synth", str(config), "-o", str(folder), "--force", "-q", *map(str, more)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"pathfit synth {config} ended with {done.returncode}:\n{done.stderr[-2000:]}")


def read_table(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def read_scalars(result):
    """Rows of a result's parameters.csv, then its photos' gains as rows of the same columns."""
    gains = [{"name": f"{r['image']}.exposure", "value": r["gain"], "standard_error": r["gain_standard_error"]}
             for r in read_table(result / "exposure.csv")]
    return read_table(result / "parameters.csv") + gains


def peer_environment():
    """With the LLVM that does not abort on processors with AVX-512, if it is where Debian puts it."""
    environment = dict(os.environ, PYTHONDONTWRITEBYTECODE="1")
    library = Path("/usr/lib/x86_64-linux-gnu/libLLVM.so.19.1")
    if library.exists():
        environment.setdefault("DRJIT_LIBLLVM_PATH", str(library))
    return environment
