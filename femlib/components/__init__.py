"""Damage as components: a stiffness that is affine in the damage parameters, solved exactly from one factorisation.

    K(mu) = K_0 - sum_i mu_i K_i,

K_i being the stiffness of region i. A region's nodes are its ports b, shared with the rest of the structure, and its
interior nodes i. Inside the region every stiffness scales by 1 - mu, so its condensation on the ports scales too:

    T_i = K_bb - K_bi K_ii^-1 K_ib   (region alone),   S(mu) = S_0 - sum_i mu_i T_i,   S(mu) u_b = S_0 u_0,b,

S_0 being the undamaged structure condensed on all ports and u_0 its solution: the condensed load does not depend on
mu. The whole solution follows from forces that stand for the damage,

    u = K_0^-1 (f + w),   w_b = mu T_i u_b + mu / (1 - mu) K_bi K_ii^-1 f_i,   w_i = mu / (1 - mu) f_i.

Source: R. J. Guyan, AIAA Journal 3 (1965) 380 (static condensation); D. B. P. Huynh, D. J. Knezevic, A. T. Patera,
ESAIM M2AN 47 (2013) 213-251 (components with ports). The result is the full model's to rounding; a state costs one
dense solve of the size of the ports. `PortFlexibility` holds the same in the regions' own measures: with 28 regions the
state's system is then solved by iteration, for many states at once.
"""

from femlib.components.flexibility import PortFlexibility, port_flexibility
from femlib.components.regions import Component, damage_row
from femlib.components.structure import DamagedStructure

__all__ = [
    "Component",
    "DamagedStructure",
    "PortFlexibility",
    "damage_row",
    "port_flexibility",
]
