"""Mitsuba in a process of its own: evaluates a table of RGL's form for pairs of directions.

Argument: the table. Standard input holds the pairs, six float64 each, the light and then the view; on standard output
follows, after `MARK`, f cos theta of the light as float64, three for each pair. The result of Mitsuba's `eval` holds
the cosine of its second direction; because these BRDFs are reciprocal, that is the light here, and the first the view.
"""

from __future__ import annotations

import sys

import mitsuba
import numpy as np

MARK = b"--- image ---\n"


def main(words: list[str]) -> int:
    pairs = np.frombuffer(sys.stdin.buffer.read(), np.float64).reshape(-1, 6)
    mitsuba.set_variant("scalar_rgb")
    plugin = mitsuba.load_dict({"type": "measured", "filename": words[0]})
    context, interaction = mitsuba.BSDFContext(), mitsuba.SurfaceInteraction3f()
    values = []
    for pair in pairs:
        interaction.wi = mitsuba.Vector3f(*pair[3:])
        values.append(np.array(plugin.eval(context, interaction, mitsuba.Vector3f(*pair[:3]))))
    sys.stdout.buffer.write(MARK + np.array(values, np.float64).tobytes())
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
