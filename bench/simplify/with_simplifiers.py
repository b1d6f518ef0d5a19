"""Simplifiers from PyPI for `cargo xtask bench simplify`: answers requests of one JSON object a line.

`mesh` reads a binary PLY file of float positions and triangles; `tool`, `faces` and `output` simplify it and write what comes out.
The seconds are those of the library's call: what it takes to bring arrays into its own classes is left out.
`measure` gives the distance of two files as MeshLab measures it.
"""

import json
import os
import pathlib
import re
import sys
import time

import numpy as np

HEADER = "ply\nformat binary_little_endian 1.0\nelement vertex {}\n" + "".join(
    f"property float {axis}\n" for axis in "xyz"
) + "element face {}\nproperty list uchar int vertex_indices\nend_header\n"
FACE = np.dtype([("n", "u1"), ("i", "<i4", 3)])


def read(path):
    data = pathlib.Path(path).read_bytes()
    start = data.index(b"end_header\n") + 11
    vertices, faces = (int(re.search(rf"element {e} (\d+)", data[:start].decode())[1]) for e in ("vertex", "face"))
    positions = np.frombuffer(data, "<f4", vertices * 3, start).reshape(-1, 3).copy()
    return positions, np.frombuffer(data, FACE, faces, start + vertices * 12)["i"].copy()


def write(path, positions, triangles):
    used, triangles = np.unique(triangles, return_inverse=True)
    triangles = triangles.reshape(-1, 3)
    faces = np.zeros(len(triangles), FACE)
    faces["n"], faces["i"] = 3, triangles
    header = HEADER.format(len(used), len(faces)).encode()
    pathlib.Path(path).write_bytes(header + np.asarray(positions, "<f4")[used].tobytes() + faces.tobytes())


def timed(call):
    start = time.perf_counter()
    result = call()
    return time.perf_counter() - start, result


def fast_simplification(positions, triangles, faces):
    import fast_simplification as library

    seconds, result = timed(lambda: library.simplify(positions, triangles, target_count=faces))
    return seconds, result[0], result[1]


def pyfqmr(positions, triangles, faces):
    import pyfqmr as library

    mesh = library.Simplify()
    mesh.setMesh(positions.astype("f8"), triangles)
    seconds, _ = timed(lambda: mesh.simplify_mesh(target_count=faces, aggressiveness=7, verbose=False))
    return seconds, *mesh.getMesh()[:2]


def pymeshlab(positions, triangles, faces):
    import pymeshlab as library

    meshes = library.MeshSet(verbose=False)
    meshes.add_mesh(library.Mesh(positions.astype("f8"), triangles))
    seconds, _ = timed(lambda: meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=faces))
    mesh = meshes.current_mesh()
    return seconds, mesh.vertex_matrix(), mesh.face_matrix()


def open3d(positions, triangles, faces):
    import open3d as library

    mesh = library.geometry.TriangleMesh(
        library.utility.Vector3dVector(positions.astype("f8")), library.utility.Vector3iVector(triangles)
    )
    seconds, mesh = timed(lambda: mesh.simplify_quadric_decimation(faces))
    return seconds, np.asarray(mesh.vertices), np.asarray(mesh.triangles)


TOOLS = {
    "fast-simplification": fast_simplification,
    "pyfqmr": pyfqmr,
    "pymeshlab": pymeshlab,
    "open3d": open3d,
}


def measure(a, b, samples):
    """Root mean square and largest distance, the larger of both ways, by MeshLab."""
    import pymeshlab as library

    found = []
    for first, second in ((a, b), (b, a)):
        meshes = library.MeshSet(verbose=False)
        for path in (first, second):
            positions, triangles = read(path)
            meshes.add_mesh(library.Mesh(positions.astype("f8"), triangles))
        area = dict(samplevert=False, sampleedge=False, sampleface=True, samplenum=samples)
        corners = dict(samplevert=True, sampleedge=False, sampleface=False, samplenum=10**9)
        by_area, by_corner = (
            meshes.get_hausdorff_distance(sampledmesh=0, targetmesh=1, maxdist=library.PercentageValue(100), **kind)
            for kind in (area, corners)
        )
        found.append((by_area["RMS"], max(by_area["max"], by_corner["max"])))
    return {"rms": max(f[0] for f in found), "largest": max(f[1] for f in found)}


def main():
    # Libraries like to print: only answers go to the real standard output.
    out = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)
    mesh = None
    for line in sys.stdin:
        request = json.loads(line)
        try:
            if "mesh" in request:
                mesh = read(request["mesh"])
                answer = {"faces": len(mesh[1])}
            elif "measure" in request:
                answer = measure(*request["measure"], request["samples"])
            else:
                seconds, positions, triangles = TOOLS[request["tool"]](*mesh, request["faces"])
                write(request["output"], positions, triangles)
                answer = {"seconds": seconds, "faces": len(triangles)}
        except Exception as error:  # told to the other side, which ends the run
            answer = {"error": f"{request.get('tool', '')} {type(error).__name__}: {error}"}
        print(json.dumps(answer), file=out, flush=True)


if __name__ == "__main__":
    main()
