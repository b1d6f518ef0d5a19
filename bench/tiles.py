"""Means over the tiles of a picture, their errors, and what it is for two of them to agree.

A reference divides the picture into a grid of equal tiles. With a box filter a tile's mean does not depend on the
resolution, so one reference serves every picture whose sides are multiples of the grid's.
"""

import json

import numpy as np


def means(image, grid):
    """Tile means of an image (height, width, 3): float64 of shape (rows, columns, 3)."""
    rows, columns = grid[1], grid[0]
    height, width, channels = image.shape
    if height % rows or width % columns:
        raise SystemExit(f"an image of {width}x{height} does not divide into {columns}x{rows} tiles")
    tiles = image.astype(np.float64).reshape(rows, height // rows, columns, width // columns, channels)
    return tiles.mean(axis=(1, 3))


def mean_and_error(replicates):
    """Mean over independent replicates (the first axis) and its standard error."""
    replicates = np.asarray(replicates)
    count = len(replicates)
    return replicates.mean(axis=0), replicates.std(axis=0, ddof=1) / np.sqrt(count)


def excess(ours, our_error, reference, reference_error):
    """|a - b| over what is allowed: 1 % of max(b, 5 % of the image mean), and 3 sigma of both. Above 1 is too much."""
    floor = 0.05 * reference.mean(axis=(0, 1))
    allowed = 0.01 * np.maximum(reference, floor) + 3 * np.hypot(our_error, reference_error)
    return np.abs(ours - reference) / allowed


def disagreement(first, second):
    """How far the differences of two (mean, error) pairs are from pure noise, per channel: the sum of squares of the
    standardised differences, itself standardised. Beyond some 4 it is not noise."""
    (a, a_error), (b, b_error) = first, second
    variance = a_error**2 + b_error**2
    known = variance > 0
    if np.any((a != b) & ~known):
        raise SystemExit("two tiles without noise differ")
    result = []
    for channel in range(a.shape[-1]):
        mask = known[..., channel]
        z2 = ((a - b)[..., channel][mask] ** 2 / variance[..., channel][mask]).sum()
        result.append((z2 - mask.sum()) / np.sqrt(2 * mask.sum()))
    return result


def write(path, head, mean, error):
    """A reference file: JSON, one row of tiles a line, R G B for each tile, from the top left."""
    lines = ["{"]
    lines += [f"  {json.dumps(key)}: {json.dumps(value)}," for key, value in head.items()]
    for name, values, digits, end in (("mean", mean, 6, ","), ("standard_error", error, 3, "")):
        rows = ["    " + ", ".join(f"{v:.{digits}g}" for v in row.reshape(-1)) for row in values]
        lines += [f'  "{name}": [', ",\n".join(rows), f"  ]{end}"]
    lines.append("}")
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


def read(path):
    """The head, the means and the standard errors of a reference file."""
    with open(path, encoding="utf-8") as file:
        head = json.load(file)
    columns, rows = head["grid"]
    mean, error = (np.array(head.pop(key)).reshape(rows, columns, 3) for key in ("mean", "standard_error"))
    return head, mean, error
