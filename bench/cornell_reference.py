#!/usr/bin/env python3
"""The Cornell box by Mitsuba: renders it in many independent parts and stores the means over tiles as numbers.

    python3 bench/cornell_reference.py            renders and writes bench/data/cornell-box-mitsuba.json
    python3 bench/cornell_reference.py --check    renders with other seeds and compares with that file
"""

import argparse
import os
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
BENCH_DIR = pathlib.Path(os.environ.get("ETENDUE_BENCH_DIR", ROOT / "target" / "bench"))
SCENE = ROOT / "scenes" / "cornell-box.toml"
DATA = ROOT / "bench" / "data" / "cornell-box-mitsuba.json"
SIZE = (512, 512)
GRID = (32, 32)
MAX_DEPTH = 8
NOISE_LIMIT = 4.0


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--variant", default="llvm_ad_rgb", help="Mitsuba variant (llvm_ad_rgb, scalar_rgb)")
    parser.add_argument("--spp", type=int, default=32, help="samples per pixel of one part")
    parser.add_argument("--parts", type=int, default=256, help="number of independent parts, each its own seed")
    parser.add_argument("--seed", type=int, help="first seed (default: 1, for --check 1000001)")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--check", action="store_true", help="compare with the stored means instead of replacing them")
    parser.add_argument("--picture", type=pathlib.Path, help="also write the mean picture, as EXR or PNG")
    options = parser.parse_args()
    if options.parts < 64:
        parser.error("at least 64 parts: the noise of a half is judged by their spread")
    if options.seed is None:
        options.seed = 1_000_001 if options.check else 1
    return options


def enter():
    """Continue this program in Mitsuba's virtual environment; ends with instructions if there is none."""
    home = BENCH_DIR / "mitsuba"
    if pathlib.Path(sys.prefix).resolve() != home.resolve():
        python = home / "bin" / "python"
        if not python.exists():
            sys.exit("Mitsuba is not there: `cargo xtask bench install` installs it")
        sys.stdout.flush()
        os.execv(python, [str(python), *sys.argv])
    sys.path.insert(0, str(ROOT / "bench" / "peers"))


def render(options, rival, np, tiles, kept):
    """Tile means of every part, and the mean picture. What is done so far is kept in a file, so that a long run that
    was interrupted goes on where it stopped."""
    mi = rival.start(options.variant, options.threads)
    renderer = rival.Renderer(mi, SCENE, SIZE, MAX_DEPTH)
    parts, picture = [], np.zeros((SIZE[1], SIZE[0], 3))
    if kept.exists():
        with np.load(kept) as file:
            parts, picture = list(file["parts"]), file["picture"]
    done, seconds = len(parts), 0.0
    for part in range(done, options.parts):
        image, took = renderer.render(options.spp, options.seed + part)
        if not np.isfinite(image).all():
            sys.exit(f"seed {options.seed + part}: a pixel is not finite")
        parts.append(tiles.means(image, GRID))
        picture += image / options.parts
        seconds += took
        if (part + 1) % 16 == 0 or part + 1 == options.parts:
            new = kept.with_suffix(".new.npz")
            np.savez(new, parts=parts, picture=picture)
            new.replace(kept)
            print(f"{part + 1}/{options.parts} parts, {seconds:.0f} s", file=sys.stderr, flush=True)
    kept.unlink(missing_ok=True)
    return np.array(parts), picture


def main():
    options = arguments()
    enter()
    import numpy as np
    import scene
    import tiles
    import with_mitsuba as rival

    cache = rival.fresh_kernel_cache()
    scene_digest = scene.digest(scene.read_toml(SCENE))
    name = f"cornell-{scene_digest[:12]}-{options.variant}-{options.spp}-{options.seed}-{options.parts}.npz"
    parts, picture = render(options, rival, np, tiles, BENCH_DIR / name)
    cache.cleanup()
    if options.picture:
        import mitsuba as mi

        mi.util.write_bitmap(str(options.picture), picture.astype(np.float32))
    mean, error = tiles.mean_and_error(parts)
    image_mean, image_error = tiles.mean_and_error(parts.mean(axis=(1, 2)))
    relative = error / np.maximum(mean, 0.05 * image_mean)
    print("image mean     " + "  ".join(f"{m:.6f} +- {e:.6f}" for m, e in zip(image_mean, image_error)))
    print(f"tile error     median {np.median(relative):.3%}, largest {relative.max():.3%}")

    half = options.parts // 2
    halves = tiles.disagreement(tiles.mean_and_error(parts[:half]), tiles.mean_and_error(parts[half:]))
    print("halves         " + "  ".join(f"{z:+.2f}" for z in halves) + f"  (noise within {NOISE_LIMIT})")
    agree = max(map(abs, halves)) < NOISE_LIMIT

    if options.check:
        head, stored, stored_error = tiles.read(DATA)
        if head["scene_digest"] != scene_digest:
            sys.exit(f"{DATA} is of another scene than {SCENE}: render it anew")
        against = tiles.disagreement((mean, error), (stored, stored_error))
        print("against stored " + "  ".join(f"{z:+.2f}" for z in against))
        whole = (image_mean - stored.mean(axis=(0, 1))) / np.hypot(
            image_error, np.sqrt((stored_error**2).sum(axis=(0, 1))) / stored[..., 0].size
        )
        print("image mean off " + "  ".join(f"{z:+.2f} sigma" for z in whole))
        agree = agree and max(map(abs, [*against, *whole])) < NOISE_LIMIT
    elif agree:
        head = {
            "scene": "scenes/cornell-box.toml",
            "scene_digest": scene_digest,
            "renderer": f"Mitsuba {rival.VERSION}, {options.variant}, path integrator",
            "command": "python3 bench/cornell_reference.py "
            f"--variant {options.variant} --spp {options.spp} --parts {options.parts} --seed {options.seed}",
            "size": SIZE,
            "filter": "box",
            "max_depth": MAX_DEPTH,
            "seeds": [options.seed, options.seed + options.parts - 1],
            "spp_per_seed": options.spp,
            "grid": GRID,
            "layout": "rows of tiles from the top, tiles from the left, R G B linear sRGB",
        }
        tiles.write(DATA, head, mean, error)
        print(f"wrote {DATA}")
    sys.exit(0 if agree else 1)


if __name__ == "__main__":
    main()
