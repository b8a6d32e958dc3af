"""The outline and the section of the UAV wing.

Source: the designed planform of the public calibration data of Kapteyn, Pretorius & Willcox (geometry table: length,
root and tip chord). The section, the spar's place and the ribs were not published: NACA 4415, 30 % and 13 are assumed.
"""

from femlib.geometry import Naca4, Planform

PLANFORM = Planform(span=1.8288, root_chord=0.43561, tip_chord=0.261112, spar_fraction=0.30)
SECTION = Naca4(camber=0.04, camber_position=0.4, thickness=0.15)
N_RIBS = 13
