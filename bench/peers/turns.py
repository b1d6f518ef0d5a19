"""The conversation with `cargo xtask bench render`: one JSON object a line in, one out, so that renderers take turns while
each stays warm.

    {"scene": FILE, "size": [W, H] or null, "threads": N}     -> {"load": seconds, "build": seconds, "name": text}
    {"spp": N, "seed": N, "output": FILE.pfm}                 -> {"render": seconds}

`load` is reading and converting the scene, `build` is what is made of it before rendering (acceleration structures, tables
of lights) where that can be told apart, else 0 and part of `render`. An error is {"error": text}.
"""

import json
import os
import sys
import traceback


def serve(load, render):
    """`load(request)` and `render(request)` answer with dictionaries. Ends with standard input."""
    # Renderers like to print: only answers go to the real standard output.
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)
    sys.stdout = sys.stderr
    for line in sys.stdin:
        request = json.loads(line)
        try:
            answer = load(request) if "scene" in request else render(request)
        except Exception as error:
            traceback.print_exc()
            answer = {"error": f"{type(error).__name__}: {error}"}
        answers.write(json.dumps(answer) + "\n")
