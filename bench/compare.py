#!/usr/bin/env python3
"""Etendue and Mitsuba on the same scene, in turn in one run: render seconds of each, their ratio, and the pictures.

    cargo build --release
    python3 bench/compare.py

Only the ratio of one run means something: machines differ, and neighbours make the same machine differ. Equal work:
box filter, the same size, samples, path length limit and threads; no denoising, clamping or adaptive sampling. What is
compared is rendering alone; loading, building and Mitsuba's compilation of kernels are given apart.
"""

import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

import rival

# Above this median error of our tiles, a tile may disagree by chance: the pictures are not judged.
NOISY = 0.005
REFERENCE = rival.ROOT / "bench" / "data" / "cornell-box-mitsuba.json"


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scene", type=pathlib.Path, default=rival.ROOT / "scenes" / "cornell-box.toml")
    parser.add_argument("--size", default="512x512", type=_size, metavar="WxH")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--depth", type=int, default=8, help="path edges, the camera segment included")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--repetitions", type=int, default=5)
    parser.add_argument("--variant", default="llvm_ad_rgb", help="Mitsuba variant (llvm_ad_rgb, scalar_rgb)")
    parser.add_argument("--etendue", type=pathlib.Path, default=_program(), help="the program (default: %(default)s)")
    parser.add_argument("--reference", type=pathlib.Path, default=REFERENCE, help="tile means to compare with")
    parser.add_argument("--fail-above", type=float, metavar="RATIO", help="fail if the median ratio of times is above")
    parser.add_argument("--json", action="store_true", help="print one object on stdout")
    parser.add_argument("more", nargs="*", help="after --: further options for etendue render")
    options = parser.parse_args()
    if options.repetitions < 2:
        parser.error("at least 2 repetitions")
    if not options.etendue.exists():
        parser.error(f"no {options.etendue}: cargo build --release")
    if not options.reference.exists():
        parser.error(f"no {options.reference}: make it with bench/cornell_reference.py")
    return options


def _size(text):
    width, height = text.split("x")
    return int(width), int(height)


def _program():
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", rival.ROOT / "target"))
    return target / "release" / "etendue"


def ours(options, seed, output):
    """One run of our program: its JSON."""
    command = [str(options.etendue), "render", str(options.scene), "-o", str(output)]
    command += ["--size", "{}x{}".format(*options.size), "--spp", str(options.spp), "--depth", str(options.depth)]
    command += ["--threads", str(options.threads), "--filter", "box", "--seed", str(seed)]
    command += ["--aov", "variance", "--quiet", "--json"]
    done = subprocess.run([*command, *options.more], stdout=subprocess.PIPE, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)} ended with {done.returncode}")
    return json.loads(done.stdout)


def layers(mi, np, path):
    """The colour of our EXR and the variance of its pixels, each (height, width, 3)."""
    found = {str(name): bitmap for name, bitmap in mi.Bitmap(str(path)).split()}
    rgb = mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False
    return tuple(np.array(found[name].convert(*rgb)) for name in ("<root>", "Variance"))


def measure(options, mi, np):
    """All runs: our JSON records, our layers, Mitsuba's seconds, its seconds to load and for its first render."""
    renderer = rival.Renderer(mi, options.scene, options.size, options.depth)
    _, first = renderer.render(options.spp, 0)
    records, pictures, theirs = [], [], []
    with tempfile.TemporaryDirectory(prefix="etendue-bench-") as scratch:
        output = pathlib.Path(scratch) / "picture.exr"
        for repetition in range(options.repetitions):
            seed = repetition + 1

            def run_ours():
                records.append(ours(options, seed, output))
                pictures.append(layers(mi, np, output))

            def run_theirs():
                theirs.append(renderer.render(options.spp, seed)[1])

            # Who goes first alternates, so that a machine that slows down or speeds up favours nobody.
            for run in (run_ours, run_theirs) if repetition % 2 == 0 else (run_theirs, run_ours):
                run()
    return records, pictures, theirs, renderer.load_seconds, first


def spread(values):
    """Smallest, median and largest."""
    return {"min": min(values), "median": statistics.median(values), "max": max(values)}


def agreement(options, stored, pictures):
    """How our pictures agree with the stored tile means; None if these are of another scene or path length."""
    import mitsuba_scene
    import numpy as np
    import tiles

    head, reference, reference_error = stored
    same = head["scene_digest"] == mitsuba_scene.digest(mitsuba_scene.read(options.scene))
    if not same or head["max_depth"] != options.depth or any(s % g for s, g in zip(options.size, head["grid"])):
        return None
    mean = np.mean([tiles.means(picture, head["grid"]) for picture, _ in pictures], axis=0)
    pixels = options.size[0] * options.size[1] / (mean.shape[0] * mean.shape[1])
    variance = np.mean([tiles.means(variance, head["grid"]) for _, variance in pictures], axis=0)
    error = np.sqrt(variance / (pixels * len(pictures)))
    excess = tiles.excess(mean, error, reference, reference_error)
    image, image_reference = mean.mean(axis=(0, 1)), reference.mean(axis=(0, 1))
    median_error = float(np.median(error / np.maximum(reference, 0.05 * image_reference)))
    return {
        "judged": median_error < NOISY,
        "tiles": int(excess.shape[0] * excess.shape[1]),
        "disagreeing": int((excess.max(axis=2) > 1).sum()),
        "worst": float(excess.max()),
        "median_error": median_error,
        "image_mean_off": [float(x) for x in image / image_reference - 1],
    }


def report(result):
    """The result for people."""
    print(f"{result['work']}, {result['repetitions']} repetitions each; smallest, median, largest")
    for name in ("etendue", "mitsuba"):
        print(f"  {name:8} render s  {_three(result[name]['render_seconds'])}")
    print(f"  ratio    of times  {_three(result['ratio'])}   (below 1: etendue is faster)")
    seconds = result["etendue"]["other_seconds"]
    print("  etendue  " + ", ".join(f"{name} {s:.3f} s" for name, s in seconds.items()))
    first = "  mitsuba  load {load_seconds:.3f} s, first render with compilation {first_render_seconds:.3f} s"
    print(first.format(**result["mitsuba"]))
    found = result["agreement"]
    if found is None:
        print("  pictures not compared: the stored means are of another scene, path length or grid")
    else:
        print(
            f"  pictures {found['tiles'] - found['disagreeing']} of {found['tiles']} tiles agree, the worst at "
            f"{found['worst']:.2f} of what is allowed; our error {found['median_error']:.2%}; "
            "image mean off by " + ", ".join(f"{x:+.3%}" for x in found["image_mean_off"])
        )
        if not found["judged"]:
            print(f"  (above an error of {NOISY:.1%} tiles disagree by chance: not judged)")


def _three(values):
    return "{min:8.3f} {median:8.3f} {max:8.3f}".format(**values)


def main():
    options = arguments()
    rival.enter()
    cache = rival.fresh_kernel_cache()
    mi = rival.load(options.variant, options.threads)
    import numpy as np
    import tiles

    stored = tiles.read(options.reference)
    records, pictures, theirs, load, first = measure(options, mi, np)
    cache.cleanup()
    mine = [record["seconds"]["render"] for record in records]
    ratio = spread([a / b for a, b in zip(mine, theirs)])
    width, height = options.size
    result = {
        "work": f"{options.scene.name}, {width}x{height}, {options.spp} spp, depth {options.depth}, "
        f"{options.threads} threads",
        "repetitions": options.repetitions,
        "etendue": {
            "render_seconds": spread(mine),
            "other_seconds": {k: v for k, v in records[-1]["seconds"].items() if k != "render"},
        },
        "mitsuba": {
            "version": f"{mi.__version__} {options.variant}",
            "render_seconds": spread(theirs),
            "load_seconds": load,
            "first_render_seconds": first,
        },
        "ratio": ratio,
        "agreement": agreement(options, stored, pictures),
    }
    if options.json:
        print(json.dumps(result))
    else:
        report(result)
    slow = options.fail_above is not None and ratio["median"] > options.fail_above
    found = result["agreement"]
    wrong = found is not None and found["judged"] and found["disagreeing"] > 0
    if slow:
        print(f"the median ratio is above {options.fail_above}", file=sys.stderr)
    sys.exit(1 if slow or wrong else 0)


if __name__ == "__main__":
    main()
