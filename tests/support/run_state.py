"""Checkpoints of runs, for tests and benchmarks in Python."""
import struct


def from_cbor(data, at=0):
    """The value that begins at `at`, and where it ends; what states contain of RFC 8949."""
    major, short = data[at] >> 5, data[at] & 31
    size = {24: 1, 25: 2, 26: 4, 27: 8}.get(short, 0)
    raw = data[at + 1:at + 1 + size]
    number, at = int.from_bytes(raw, "big") if size else short, at + 1 + size
    if major in (0, 1):
        return (number if major == 0 else -1 - number), at
    if major in (2, 3):
        text = data[at:at + number]
        return (text if major == 2 else text.decode()), at + number
    if major == 7:
        return (struct.unpack(">f" if size == 4 else ">d", raw)[0] if size else {20: False, 21: True, 22: None}[short]), at
    items = []
    for _ in range(number if major == 4 else 2 * number):
        item, at = from_cbor(data, at)
        items.append(item)
    return (items if major == 4 else dict(zip(items[::2], items[1::2]))), at


def final_bytes(folder):
    """What must be equal between runs of one seed: results and the last checkpoint but for its time."""
    files = sorted(p for p in (folder / "result").rglob("*") if p.suffix in {".ply", ".exr", ".glb", ".csv"})
    assert len(files) >= 5, files
    content = {p.relative_to(folder).as_posix(): p.read_bytes() for p in files}
    newest = sorted((folder / "checkpoints").glob("state_*.cbor"))[-1]
    state = from_cbor(from_cbor(newest.read_bytes())[0]["payload"])[0]
    del state["wall_s"]
    return {**content, **state}
