"""Volumes of bytes in NIfTI-1 files, as Debian's mricron-data has them."""

import gzip
import struct
from dataclasses import dataclass

HEADER_BYTES = 348
UNSIGNED_BYTE = 2


@dataclass
class Volume:
    size: tuple  # voxels along x, y, z
    spacing: tuple  # millimetres
    values: bytes  # x fastest


def read_volume(path):
    """The first volume of a NIfTI-1 file (.nii or .nii.gz) of unsigned bytes."""
    opener = gzip.open if str(path).endswith(".gz") else open
    with opener(path, "rb") as file:
        data = file.read()
    order = next((o for o in "<>" if struct.unpack_from(o + "i", data)[0] == HEADER_BYTES), None)
    if order is None:
        raise ValueError(f"{path}: not a NIfTI-1 file")
    size = struct.unpack_from(order + "3h", data, 42)
    kind = struct.unpack_from(order + "h", data, 70)[0]
    spacing = tuple(abs(s) for s in struct.unpack_from(order + "3f", data, 80))
    start = int(struct.unpack_from(order + "f", data, 108)[0])
    if kind != UNSIGNED_BYTE:
        raise ValueError(f"{path}: values of type {kind}, expected unsigned bytes")
    values = data[start:start + size[0] * size[1] * size[2]]
    if len(values) != size[0] * size[1] * size[2]:
        raise ValueError(f"{path}: ends before its last voxel")
    return Volume(size, spacing, values)
