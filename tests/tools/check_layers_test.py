"""Checks that tools/check_layers.py passes a good tree and fails each kind of bad one."""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SCRIPT = Path(__file__).resolve().parent.parent.parent / "tools" / "check_layers.py"

GOOD = {
    "layers.txt": "# comment\nbase:\nmesh: base\ncli: mesh\n",
    "src/remaps/base/point.h": "#include <cmath>\n",
    "src/remaps/mesh/patch.h": '#include "remaps/base/point.h"\n#include "remaps/mesh/star.h"\n',
    "src/remaps/mesh/star.h": "",
    "cli/verbs.h": "",
    "cli/main.cpp": '#include "verbs.h"\n#include "remaps/mesh/patch.h"\n',
    "build/generated/main.cpp": "",
}


def run(files):
    with tempfile.TemporaryDirectory() as root:
        for name, text in files.items():
            path = Path(root) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        result = subprocess.run([sys.executable, SCRIPT, root], capture_output=True, text=True)
        return result.returncode, result.stdout


class CheckLayers(unittest.TestCase):
    def expect_offence(self, change, message):
        code, output = run({**GOOD, **change})
        self.assertEqual(code, 1, output)
        self.assertIn(message, output)

    def test_passes_a_good_tree(self):
        self.assertEqual(run(GOOD), (0, ""))

    def test_names_file_and_line_of_an_include_of_a_higher_room(self):
        self.expect_offence({"src/remaps/base/point.h": '\n#include "remaps/mesh/patch.h"\n'},
                            "src/remaps/base/point.h:2: base may not include remaps/mesh/patch.h")

    def test_holds_the_command_line_to_its_line(self):
        self.expect_offence({"cli/main.cpp": '#include "remaps/base/point.h"\n'},
                            "cli/main.cpp:1: cli may not include remaps/base/point.h")

    def test_refuses_includes_relative_to_the_file(self):
        self.expect_offence({"src/remaps/mesh/patch.h": '#include "../base/point.h"\n'},
                            'src/remaps/mesh/patch.h:1: write "remaps/ROOM/FILE"')

    def test_refuses_two_files_of_one_name(self):
        self.expect_offence({"src/remaps/base/patch.h": ""}, "has the name of")

    def test_refuses_a_room_without_a_line(self):
        self.expect_offence({"src/remaps/attic/box.h": ""}, "room attic has no line")

    def test_refuses_rooms_in_a_circle(self):
        self.expect_offence({"layers.txt": "base: mesh\nmesh: base\ncli: mesh\n"},
                            "rooms in a circle: base -> mesh -> base")

    def test_refuses_a_line_that_names_no_room(self):
        self.expect_offence({"layers.txt": "base:\nmesh: base\ncli: mesh attic\n"},
                            "layers.txt:3: cli may include attic, which has no line")


if __name__ == "__main__":
    unittest.main()
