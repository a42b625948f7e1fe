"""Mouse and keyboard, as the Help menu shows them: headings, and the effect of each gesture and key."""

from __future__ import annotations

HELP = """Mouse in the viewport
Left-drag\trotate the model
Middle-drag\tmove
Wheel\tzoom
Ctrl+left-drag\tmove the light, rotate the environment
F\tframe the model, fit the picture
H, W, G\tbaked light: SH, wavelet, Gaussian
M, D, R\tshading map, direct light, reference
Tab\tswap the two compared modes
B, E\tboth modes separated by a line, their difference

Pictures
Wheel\tzoom under the pointer
1\t100 %
Left, Right\tprevious, next photograph
X\texclude the photograph
M\tmark clipped texels
Arrow keys\tmove the chosen point or reflection (Ctrl: finer, Shift: farther)
Ins, Del\tadd, delete a point; Esc leaves

BRDFs
Enter\tadd the chosen BRDF of the library
Space, Del\tshow or hide, remove an entry of the list
Ctrl+left-drag\tmove the light of the lobes
L\tlogarithmic or linear
Ctrl+F, Esc\tsearch the library, show all views

Factors
Ctrl+Enter\tbegin a run
Click a point\tpreview and export that number of terms
Space, Del\tpause or go on with, remove a run of the list
Left, Right\tfewer, more terms while on the textures

Numbers
Drag a field\tchange it
Type\ta number, a unit, or 2*3.5
Ctrl+click\treset"""


def help_table() -> str:
    """All of it as a table in HTML."""
    return f"<table cellspacing='0' cellpadding='3'>{''.join(map(_row, HELP.splitlines()))}</table>"


def _row(line: str) -> str:
    keys, tab, words = line.partition("\t")
    if not tab:
        return f"<tr><td colspan='2'><b>{keys}</b></td></tr>"
    return f"<tr><td>{keys}&nbsp;&nbsp;</td><td>{words}</td></tr>"
