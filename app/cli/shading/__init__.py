"""The verb that makes materials of a stack, of each of its arcs, and compares what they could be."""
