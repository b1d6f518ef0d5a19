#!/usr/bin/env python3
"""How fast large OBJ files are read, beside rapidobj: both in turns, in one run, on all cores.

    cargo build --release -p etendue-scene --example read_mesh
    python3 bench/obj.py [--megabytes 250] [--pairs 5] [--fail-below 0.4] [--fail-above-memory 2.5]

rapidobj 0.1.5 comes as source from PyPI and is compiled here with c++ -O3 (its header, and a main of a few lines). A file is made
once, beside it: a wavy grid of triangles with normals and texture coordinates, or positions alone (--plain). Both read
the file from the page cache. Memory is the peak of a process of its own, over the bytes of the mesh: positions, indices,
normals, texture coordinates and face materials as they are in memory in the end.
"""

import argparse
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys
import tarfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
BENCH_DIR = pathlib.Path(os.environ.get("ETENDUE_BENCH_DIR", ROOT / "target" / "bench"))
VERSION = "0.1.5"
SOURCE = r"""
#include "rapidobj.hpp"
#include <chrono>
#include <cstdio>

int main(int, char** argv) {
    auto start = std::chrono::steady_clock::now();
    auto result = rapidobj::ParseFile(argv[1], rapidobj::MaterialLibrary::Ignore());
    std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    if (result.error) {
        std::fprintf(stderr, "%s\n", result.error.code.message().c_str());
        return 1;
    }
    std::size_t faces = 0;
    for (auto const& shape : result.shapes) faces += shape.mesh.num_face_vertices.size();
    std::printf("{\"seconds\": %.6f, \"triangles\": %zu}\n", seconds.count(), faces);
}
"""


def rival():
    """The compiled reader."""
    program = BENCH_DIR / f"rapidobj-{VERSION}"
    if not program.exists():
        BENCH_DIR.mkdir(parents=True, exist_ok=True)
        wanted = ["--no-deps", "--no-binary", ":all:", "--python-version", "3.13", "-q", "-d", str(BENCH_DIR)]
        subprocess.run([sys.executable, "-m", "pip", "download", f"rapidobj=={VERSION}", *wanted], check=True)
        archive = BENCH_DIR / f"rapidobj-{VERSION}.tar.gz"
        with tarfile.open(archive) as tar:
            header = tar.extractfile(f"rapidobj-{VERSION}/src/rapidobj.hpp").read()
        (BENCH_DIR / "rapidobj.hpp").write_bytes(header)
        (BENCH_DIR / "rapidobj.cpp").write_text(SOURCE)
        command = ["c++", "-std=c++17", "-O3", "-DNDEBUG", "rapidobj.cpp", "-o", program.name, "-pthread"]
        subprocess.run(command, cwd=BENCH_DIR, check=True)
    return program


def make(megabytes, plain):
    """The file, about as large as asked for."""
    path = BENCH_DIR / f"grid-{megabytes}{'-plain' if plain else ''}.obj"
    if path.exists():
        return path
    # Bytes of a vertex with its two triangles, about.
    side = int(math.sqrt(megabytes * 1e6 / (80 if plain else 210)))
    BENCH_DIR.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part")
    with open(part, "w", encoding="ascii") as out:
        heights = [0.05 * math.sin(0.05 * i) for i in range(side)]
        for y in range(side):
            lines = []
            for x in range(side):
                u, v = x / (side - 1), y / (side - 1)
                lines.append(f"v {2 * u - 1:.6f} {heights[x] + heights[y]:.6f} {2 * v - 1:.6f}\n")
                if not plain:
                    lines.append(f"vt {u:.6f} {v:.6f}\nvn {-heights[x]:.4f} {1 - heights[y]:.4f} {heights[y]:.4f}\n")
            out.writelines(lines)
        corner = "{0}" if plain else "{0}/{0}/{0}"
        face = f"f {corner} {corner.replace('0', '1')} {corner.replace('0', '2')}\n".format
        for y in range(side - 1):
            lines = []
            for x in range(side - 1):
                a = y * side + x + 1
                lines.append(face(a, a + 1, a + side + 1))
                lines.append(face(a, a + side + 1, a + side))
            out.writelines(lines)
    part.rename(path)
    return path


def run(program, path):
    """What a reader printed, and its peak memory in bytes."""
    with subprocess.Popen([str(program), str(path)], stdout=subprocess.PIPE) as process:
        text = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"{program} failed")
    return json.loads(text), usage.ru_maxrss * 1024


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--megabytes", type=int, default=250)
    parser.add_argument("--plain", action="store_true", help="positions and faces alone")
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--program", type=pathlib.Path, help="our reader (default: the release build's example)")
    parser.add_argument("--fail-below", type=float, help="fail if ours has less than this part of the other's speed")
    parser.add_argument("--fail-above-memory", type=float, help="fail if ours takes more memory than so many meshes")
    parser.add_argument("--rival", action="store_true", help="install and compile rapidobj, and print where it is")
    args = parser.parse_args()
    if args.rival:
        print(rival())
        return
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    ours = args.program or target / "release" / "examples" / "read_mesh"
    if not ours.exists():
        sys.exit("build it first: cargo build --release -p etendue-scene --example read_mesh")
    other, path = rival(), make(args.megabytes, args.plain)
    size = path.stat().st_size
    # Into the page cache; not in one piece, since a child's peak starts at what its parent had.
    with open(path, "rb") as file:
        while file.read(1 << 20):
            pass
    seconds, ratios, memory, mesh = ([], []), [], 0, 0
    for _ in range(args.pairs):
        theirs, _ = run(other, path)
        mine, peak = run(ours, path)
        if theirs["triangles"] != mine["triangles"]:
            sys.exit("the readers do not find the same number of triangles")
        seconds[0].append(theirs["seconds"])
        seconds[1].append(mine["seconds"])
        ratios.append(theirs["seconds"] / mine["seconds"])
        memory, mesh = max(memory, peak), mine["mesh_bytes"]
    speed, taken = statistics.median(ratios), memory / mesh
    print(f"{size / 1e6:.0f} MB, {mine['triangles']} triangles, {args.pairs} pairs, medians")
    for name, times in zip(("rapidobj", "etendue"), seconds):
        median = statistics.median(times)
        print(f"  {name:10} {median:.3f} s  {size / median / 1e6:.0f} MB/s")
    print(f"  speed      {speed:.2f} of rapidobj's (pairs: {', '.join(f'{r:.2f}' for r in ratios)})")
    print(f"  memory     {memory / 1e6:.0f} MB at the peak, {taken:.2f} times the mesh of {mesh / 1e6:.0f} MB")
    failed = args.fail_below is not None and speed < args.fail_below
    failed |= args.fail_above_memory is not None and taken > args.fail_above_memory
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
