#!/usr/bin/env python3
"""Reads the .vtp files that remaps writes, and is strict about it: every byte must be where the XML says.

    read_vtp.py FILE...

Written from docs/formats/meshes.md, without the library. Prints the counts, exits with 1 at the first
thing that is not as it should be. read_vtp(path) gives the arrays.
"""

import struct
import sys
import xml.etree.ElementTree as ElementTree

TYPES = {"Float32": "f", "Float64": "d", "Int8": "b", "UInt8": "B", "Int16": "h", "UInt16": "H", "Int32": "i",
         "UInt32": "I", "Int64": "q", "UInt64": "Q"}
MARK = b'<AppendedData encoding="raw">\n_'
END = b"\n</AppendedData>\n</VTKFile>\n"


class BadFile(Exception):
    pass


def expect(true, what):
    if not true:
        raise BadFile(what)


def read_arrays(elements, data):
    """Returns the numbers of each array; checks that the arrays tile data."""
    arrays, at = [], 0
    for element in elements:
        expect(element.get("format") == "appended", "an array that is not appended")
        expect(int(element.get("offset")) == at, f"{element.get('Name')} at {element.get('offset')}, not {at}")
        (size,) = struct.unpack_from("<Q", data, at)
        code = TYPES[element.get("type")]
        expect(size % struct.calcsize(code) == 0, f"{element.get('Name')}: {size} bytes")
        expect(at + 8 + size <= len(data), f"{element.get('Name')} is longer than the file")
        arrays.append(struct.unpack_from(f"<{size // struct.calcsize(code)}{code}", data, at + 8))
        at += 8 + size
    expect(at == len(data), f"{len(data) - at} bytes behind the last array")
    return arrays


def read_vtp(path):
    """Returns points, triangles, {name: values of cells}, {name: values of points}; a value is a number or a tuple."""
    with open(path, "rb") as file:
        content = file.read()
    begin = content.find(MARK)
    expect(begin >= 0 and content.endswith(END), "no appended data")
    root = ElementTree.fromstring(content[:begin] + b"</VTKFile>")
    expect(root.tag == "VTKFile" and root.get("type") == "PolyData", "not PolyData")
    expect(root.get("byte_order") == "LittleEndian" and root.get("header_type") == "UInt64", "byte order or header")
    pieces = root.findall("PolyData/Piece")
    expect(len(pieces) == 1, f"{len(pieces)} pieces")
    piece = pieces[0]
    elements = list(piece.iter("DataArray"))
    found = dict(zip(elements, read_arrays(elements, content[begin + len(MARK):-len(END)])))
    arrays = {e.get("Name"): found[e] for part in ("Points", "Polys") for e in piece.findall(f"{part}/DataArray")}
    vertices, faces = int(piece.get("NumberOfPoints")), int(piece.get("NumberOfPolys"))
    for other in ("NumberOfVerts", "NumberOfLines", "NumberOfStrips"):
        expect(piece.get(other) == "0", other)
    expect(len(arrays["Points"]) == 3 * vertices, "number of coordinates")
    expect(len(arrays["connectivity"]) == 3 * faces, "number of corners")
    expect(arrays["offsets"] == tuple(range(3, 3 * faces + 1, 3)), "offsets")
    expect(all(0 <= v < vertices for v in arrays["connectivity"]), "a corner out of range")
    points = list(zip(*[iter(arrays["Points"])] * 3))
    triangles = list(zip(*[iter(arrays["connectivity"])] * 3))
    cells = read_values(piece.findall("CellData/DataArray"), found, faces)
    if "patch_id" in cells:
        check_numbering(cells, faces)
    return points, triangles, cells, read_values(piece.findall("PointData/DataArray"), found, vertices)


def read_values(elements, found, count):
    """Returns {name: values} of so many points or cells."""
    result = {}
    for element in elements:
        name, width, values = element.get("Name"), int(element.get("NumberOfComponents")), found[element]
        expect(len(values) == width * count, f"{len(values)} numbers of {name} for {count}, {width} each")
        expect(name not in result, f"{name} is there twice")
        result[name] = values if width == 1 else tuple(zip(*[iter(values)] * width))
    return result


def check_numbering(cells, faces):
    """Faces 4^J f ... 4^J (f + 1) - 1 are the parts of base face f."""
    level = cells["level"][0] if faces else 0
    each = 4**level
    expect(set(cells["level"]) <= {level}, "faces of several levels")
    expect(cells["base_face"] == tuple(f // each for f in range(faces)), "base_face")
    expect(cells["patch_id"] == tuple(f % each for f in range(faces)), "patch_id")


def main():
    for path in sys.argv[1:]:
        try:
            points, triangles, cells, of_points = read_vtp(path)
        except (BadFile, struct.error, KeyError, ElementTree.ParseError) as error:
            sys.exit(f"{path}: {error}")
        print(f"{path}: {len(points)} points, of each: {', '.join(of_points) or 'nothing'}; "
              f"{len(triangles)} triangles, of each: {', '.join(cells) or 'nothing'}")


if __name__ == "__main__":
    main()
