#!/usr/bin/env python3
"""Runs tools/codec_identity.py over a closed and an open mesh, and with a binary that errs, which it must notice.

Arguments: the binary, a mesh. Exits with 77 if there is no numpy, which is no failure.
"""

import pathlib
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import decode_archive_test  # noqa: E402

TOOL = pathlib.Path(__file__).resolve().parents[2] / "tools" / "codec_identity.py"

# Does as the binary does, and then moves the first vertex of a mesh or turns its last face round.
ERRING = """#!/usr/bin/env python3
import pathlib, struct, subprocess, sys
done = subprocess.run([{remaps!r}, *sys.argv[1:]]).returncode
if sys.argv[1] == "decode" and pathlib.Path(sys.argv[3]).name == {name!r}:
    path = pathlib.Path(sys.argv[3])
    data = bytearray(path.read_bytes())
    {damage}
    path.write_bytes(data)
sys.exit(done)
"""
MOVED = ('at = data.index(b"end_header\\n") + 11; '
         'struct.pack_into("<f", data, at, struct.unpack_from("<f", data, at)[0] * (1 + 1e-6))')
TURNED = 'data[-4:], data[-8:-4] = data[-8:-4], data[-4:]'


def run_tool(remaps, *meshes):
    done = subprocess.run([sys.executable, TOOL, *meshes, "--remaps", remaps, "--level", "2", "--prefixes", "4", "--",
                           "--base-vertices", "30"], capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def main():
    remaps, mesh = sys.argv[1:]
    try:
        import numpy  # noqa: F401
    except ImportError:
        print("skipped: no numpy; Debian has it as python3-numpy")
        sys.exit(77)
    with tempfile.TemporaryDirectory() as name:
        directory = pathlib.Path(name)
        annulus = directory / "annulus.ply"
        decode_archive_test.write_open_mesh(annulus)
        code, text = run_tool(remaps, mesh, annulus)
        print(text)
        if code != 0 or "6 of 6 as they should be" not in text:
            sys.exit(f"the tool ended with {code}")
        for damaged, damage, words in (("again.ply", MOVED, "encoded again: other vertices"),
                                       ("prefix.ply", TURNED, "edges between faces of opposite orientation"),
                                       ("ours.ply", MOVED, "decode_archive.py's vertices")):
            erring = directory / "erring"
            erring.write_text(ERRING.format(remaps=remaps, name=damaged, damage=damage))
            erring.chmod(0o755)
            code, text = run_tool(erring, annulus)
            if code != 1 or text.count(words) != 3:
                sys.exit(f"{damaged} was damaged, and the tool ended with {code}:\n{text}")
            print(f"{damaged} damaged: noticed")


if __name__ == "__main__":
    main()
