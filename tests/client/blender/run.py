#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs one test file inside Blender: run.py result_test.py. The packed add-on is tested, with a new, empty user folder.
Exits with 77 if Blender is not installed, or if all tests were skipped.

FRACTURE_TEST_SERVER names the program fracture-server, FRACTURE_TEST_MESHES folders of real meshes,
FRACTURE_TEST_BLENDER another Blender, and FRACTURE_TEST_PICTURES a folder for pictures. A file whose name begins with
"window" gets a window in Xvfb; all others run in the background.
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
PACK = HERE.parents[2] / "client" / "blender" / "pack.py"
SKIPPED = 77
NO_WINDOW = ("Unable to open a display", "context", "Xvfb failed")  # messages of Blender or Xvfb without a display


def skip(why):
    print(f"skipped: {why}")
    sys.exit(SKIPPED)


def main():
    test = (HERE / sys.argv[1]).resolve()
    blender = os.environ.get("FRACTURE_TEST_BLENDER") or shutil.which("blender")
    server = os.environ.get("FRACTURE_TEST_SERVER", "")
    if not blender:
        skip("Blender is not installed (Debian: apt-get install --no-install-recommends blender)")
    if not os.access(server, os.X_OK):
        skip("FRACTURE_TEST_SERVER does not name the program fracture-server")
    command = [blender, "--factory-startup", "--python-exit-code", "1", "--python", str(test)]
    if test.name.startswith("window"):
        if not (shutil.which("xvfb-run") and shutil.which("xauth")):
            skip("xvfb-run is not installed (Debian: xvfb, xauth)")
        command = ["xvfb-run", "-a", "-s", "-screen 0 1400x1000x24", *command, "--enable-event-simulate",
                   "--window-geometry", "0", "0", "1400", "1000"]
    else:
        command[1:1] = ["--background"]
    with tempfile.TemporaryDirectory(prefix="fracture-blender-") as folder:
        packed = pathlib.Path(folder) / "fracture_blender.zip"
        subprocess.run([sys.executable, PACK, "--describe", server, packed], check=True)
        # Blender looks for the Python library next to the first python3 on the PATH, which must be the system's.
        environment = {**os.environ, "PATH": os.pathsep.join((os.path.dirname(blender), os.defpath)),
                       "FRACTURE_TEST_ZIP": str(packed), "FRACTURE_TEST_PYTHON": sys.executable,
                       "BLENDER_USER_RESOURCES": str(pathlib.Path(folder) / "user"),
                       "LIBGL_ALWAYS_SOFTWARE": "1", "TMPDIR": folder, "PYTHONDONTWRITEBYTECODE": "1"}
        ended = subprocess.run(command, env=environment, check=False, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        print(ended.stdout, end="")
        if ended.returncode and "Traceback" not in ended.stdout and any(words in ended.stdout for words in NO_WINDOW):
            skip("Blender gets no window here (Debian: libgl1-mesa-dri)")
        sys.exit(ended.returncode)


if __name__ == "__main__":
    main()
