#!/usr/bin/env python3
"""Compares two binaries of etendue over scenes, in turns.

    bench/ours.py OLD NEW [--scene FILE]... [--spp 16] [--pairs 5] [--threads 1] [--depth 8]

Prints for each scene the median seconds of processor time that each binary needs, the median of the ratios within pairs
(below 1: NEW is faster) with the least and the largest, and whether the pictures are the same to the bit. On a machine with
other work only the ratios mean anything.
"""

import argparse
import hashlib
import pathlib
import resource
import statistics
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENES = ["cornell-box", "mesh", "glass-spheres", "still-life"]


def seconds(binary, scene, output, options):
    """Processor seconds, user mode, of one render."""
    command = [binary, "render", scene, "-o", output, "--filter", "box", "--quiet", "--spp", str(options.spp)]
    command += ["--depth", str(options.depth), "--threads", str(options.threads)]
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("--scene", action="append", help="scene file; default: four of scenes/")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--depth", type=int, default=8)
    options = parser.parse_args()
    scenes = options.scene or [str(ROOT / "scenes" / f"{name}.toml") for name in SCENES]
    with tempfile.TemporaryDirectory() as folder:
        for scene in scenes:
            times, hashes = ([], []), set()
            for pair in range(options.pairs):
                # Who begins alternates, so that a trend of the machine favours neither.
                for which in (0, 1) if pair % 2 == 0 else (1, 0):
                    output = f"{folder}/{which}.exr"
                    times[which].append(seconds((options.old, options.new)[which], scene, output, options))
                    hashes.add(hashlib.sha256(pathlib.Path(output).read_bytes()).hexdigest())
            ratios = sorted(new / old for old, new in zip(*times))
            old, new = map(statistics.median, times)
            same = "same picture" if len(hashes) == 1 else "other picture"
            name = pathlib.Path(scene).stem
            print(f"{name:16} {old:7.2f} s {new:7.2f} s  ratio {statistics.median(ratios):.3f}", end=" ")
            print(f"({ratios[0]:.3f} to {ratios[-1]:.3f})  {same}", flush=True)


if __name__ == "__main__":
    main()
