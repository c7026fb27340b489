#!/usr/bin/env python3
"""Makes .vtp files with the binary and reads them: with tools/read_vtp.py, or, called with "vtk", with VTK.

Arguments: the binary, a mesh, "strict" or "vtk". Exits with 77 if there is no VTK, which is no failure.
"""

import pathlib
import struct
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import read_vtp  # noqa: E402
import textured_mesh  # noqa: E402

LEVEL = 3


def run(*command):
    done = subprocess.run(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} ended with exit code {done.returncode}:\n{done.stdout}")


def expect(true, what):
    if not true:
        sys.exit(what)


def read_off(path):
    """The same mesh in text, to compare with."""
    lines = path.read_text().splitlines()
    vertices = int(lines[1].split()[0])
    points = [tuple(struct.unpack("<3f", struct.pack("<3f", *map(float, line.split())))) for line in
              lines[2:2 + vertices]]
    return points, [tuple(map(int, line.split()[1:])) for line in lines[2 + vertices:]]


def check_strictly(path, points, triangles, level):
    found_points, found_triangles, cells, _ = read_vtp.read_vtp(path)
    expect(found_points == points, f"{path}: other points")
    expect(found_triangles == triangles, f"{path}: other triangles")
    expect(sorted(cells) == ["base_face", "level", "patch_id"], f"{path}: cell data {sorted(cells)}")
    expect(set(cells["level"]) == {level}, f"{path}: level")
    content = path.read_bytes()
    for damaged in (content[:-1], content[:2000] + content[2001:], content.replace(b'offset="0"', b'offset="8"')):
        path.write_bytes(damaged)
        try:
            read_vtp.read_vtp(path)
        except Exception:  # whatever it stumbles over
            continue
        sys.exit(f"read_vtp.py takes a damaged {path.name}")


def check_with_vtk(make_reader, path, points, triangles, level):
    errors = []
    reader = make_reader()
    reader.AddObserver("ErrorEvent", lambda *_: errors.append("error"))
    reader.AddObserver("WarningEvent", lambda *_: errors.append("warning"))
    reader.SetFileName(str(path))
    reader.Update()
    expect(not errors, f"{path}: VTK has {errors}")
    mesh = reader.GetOutput()
    expect(mesh.GetNumberOfPoints() == len(points), f"{path}: {mesh.GetNumberOfPoints()} points in VTK")
    expect(mesh.GetNumberOfCells() == len(triangles), f"{path}: {mesh.GetNumberOfCells()} cells in VTK")
    for v, point in enumerate(points):
        expect(mesh.GetPoint(v) == point, f"{path}: point {v} is {mesh.GetPoint(v)} in VTK, not {point}")
    data = mesh.GetCellData()
    base_face, levels, patch = (data.GetArray(name) for name in ("base_face", "level", "patch_id"))
    for f, triangle in enumerate(triangles):
        cell = mesh.GetCell(f)
        expect(cell.GetClassName() == "vtkTriangle", f"{path}: cell {f} is a {cell.GetClassName()}")
        expect(tuple(cell.GetPointId(k) for k in range(3)) == triangle, f"{path}: cell {f}")
        expect((base_face.GetValue(f), levels.GetValue(f), patch.GetValue(f)) ==
               (f // 4**level, level, f % 4**level), f"{path}: data of cell {f}")


def check_attributes(remaps, directory, make_reader):
    """Everything that a mesh carries is in the file, and VTK finds it, if there is a reader."""
    path = directory / "textured.vtp"
    textured_mesh.write_textured_mesh(directory / "torus.ply")
    run(remaps, "remesh", directory / "torus.ply", path, "--base-vertices", "40", "--level", "3", "--no-measure",
        "--quiet")
    points, triangles, cells, of_points = read_vtp.read_vtp(path)
    expect(sorted(of_points) == ["colour", "height", "normal"], f"{path}: points have {sorted(of_points)}")
    expect(sorted(cells) == ["base_face", "level", "part", "patch_id", "uv"], f"{path}: cells have {sorted(cells)}")
    for point, colour, height in zip(points, of_points["colour"], of_points["height"]):
        expect(max(abs(a - b) for a, b in zip(colour, textured_mesh.colour_of(point))) <= 2, f"{path}: colours")
        expect(abs(height - point[2]) < 1e-5, f"{path}: height")
    expect(set(cells["part"]) == set(range(5)), f"{path}: parts {set(cells['part'])}")
    expect(all(max(uv[axis::2]) - min(uv[axis::2]) < 0.4 for uv in cells["uv"] for axis in (0, 1)), f"{path}: seams")
    if make_reader is not None:
        reader = make_reader()
        reader.SetFileName(str(path))
        reader.Update()
        data, cell_data = reader.GetOutput().GetPointData(), reader.GetOutput().GetCellData()
        expect(data.GetScalars().GetName() == "colour" and data.GetNormals().GetName() == "normal", "roles in VTK")
        for v in range(len(points)):
            expect(data.GetArray("colour").GetTuple(v) == of_points["colour"][v], f"{path}: colour {v} in VTK")
            expect(data.GetArray("height").GetValue(v) == of_points["height"][v], f"{path}: height {v} in VTK")
        for f in range(len(triangles)):
            expect(cell_data.GetArray("uv").GetTuple(f) == cells["uv"][f], f"{path}: uv {f} in VTK")
    print(f"{path.name}: attributes as they should be")


def main():
    remaps, mesh, how = sys.argv[1:]
    if how == "vtk":
        try:
            from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
        except ImportError:
            print("skipped: no VTK for Python; Debian has it as python3-vtk9 (215 MB with what it needs)")
            sys.exit(77)
    with tempfile.TemporaryDirectory() as name:
        directory = pathlib.Path(name)
        bundle = directory / "b.remaps"
        run(remaps, "parameterize", mesh, bundle, "--quiet")
        for extension in ("vtp", "off"):
            run(remaps, "resample", bundle, directory / f"out.{extension}", "--levels", f"0..{LEVEL}", "--no-measure",
                "--quiet")
        for level in range(LEVEL + 1):
            points, triangles = read_off(directory / f"out-l{level}.off")
            path = directory / f"out-l{level}.vtp"
            if how == "vtk":
                check_with_vtk(vtkXMLPolyDataReader, path, points, triangles, level)
            else:
                check_strictly(path, points, triangles, level)
            print(f"{path.name}: {len(points)} points and {len(triangles)} cells as they should be")
        check_attributes(remaps, directory, vtkXMLPolyDataReader if how == "vtk" else None)


if __name__ == "__main__":
    main()
