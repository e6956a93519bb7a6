#!/usr/bin/env python3
"""The same programs through `headstock simulate` and through LinuxCNC's trajectory planner, under the same limits (velocity
500 mm/s, acceleration 2,000 mm/s² on every axis, jerk not limited, tolerance 0.01 mm): who needs longer?

    tests/bench/peer.py [--bin build/release/bin/headstock] [--peer ../shared/tools/linuxcnc-peer] [PROGRAM…]

The wavy surface of the motion bench always, PROGRAMs (G0-G3, mm, without tool words) besides. LinuxCNC runs in real time: the
machine should have nothing else to do. Exit status 1 when Headstock needs longer for one."""
import argparse
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

from judged_mill import ACCELERATION, TOLERANCE, VELOCITY, machine_file

options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
options.add_argument("--bin", default="build/release/bin/headstock")
options.add_argument("--peer", default="../shared/tools/linuxcnc-peer")
options.add_argument("programs", nargs="*", type=pathlib.Path)
given = options.parse_args()


def surface():
    """20 passes of 400 segments of 0.1 mm on z = 2 sin(0.8 x) cos(0.5 y), there and back, F6000."""
    for row in range(20):
        for step in range(401):
            x, y = 0.1 * (400 - step if row % 2 else step), 0.5 * row
            yield f"G1 X{x:.4f} Y{y:.4f} Z{2 * math.sin(0.8 * x) * math.cos(0.5 * y):.5f} F6000."


def moves_of(file):
    """Comments, numbers, tool, spindle and end words are left out: what is left means the same to both."""
    for line in file.read_text(errors="replace").splitlines():
        line = re.sub(r"\([^)]*\)|;.*|%", "", line).upper()
        line = re.sub(r"\b(N|O|T|S|M|D|H)\d+(\.\d*)?|G(17|21|40|43|49|54|61|64|80|90|94)\b", "", line).strip()
        if line:
            yield line


machine = machine_file("peer", 1e12)

slower = 0
with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    folder.chmod(0o755)
    (folder / "machine.toml").write_text(machine)
    for name, moves in [("surf", surface())] + [(file.stem, moves_of(file)) for file in given.programs]:
        text = "\n".join(moves)
        ours, theirs = folder / f"{name}.nc", folder / f"{name}.ngc"
        ours.write_text(f"O1\nG17 G21 G90 G94 G64\n{text}\nM30\n")
        theirs.write_text(f"G17 G21 G90 G94 G64 P{TOLERANCE}\n{text}\nM2\n")
        run = subprocess.run([given.bin, "simulate", "--profile", "fanuc-0i-m", "--machine", str(folder / "machine.toml"),
                              "--set", "lenient=true", "--quick", str(ours)], capture_output=True, text=True)
        if run.returncode != 0:
            sys.exit(f"peer: {name}: {run.stderr.strip()} {run.stdout.strip()[:200]}")
        our_s = json.loads(run.stdout)["time_s"]
        peer = subprocess.run([given.peer, "--accel", str(ACCELERATION), "--vel", str(VELOCITY), str(theirs)],
                              capture_output=True, text=True)
        if peer.returncode != 0:
            sys.exit(f"peer: LinuxCNC did not run: {peer.stderr.strip()[-200:]}")
        result = json.loads(peer.stdout.splitlines()[0])
        if result.get("error"):
            sys.exit(f"peer: LinuxCNC stopped in {name}: {result['error']}")
        their_s = result["time_s"]
        slower += our_s >= their_s
        print(f"{name:24} headstock {our_s:8.2f} s   LinuxCNC {their_s:8.2f} s   ratio {our_s / their_s:.3f}", flush=True)
sys.exit(1 if slower else 0)
