"""Calibration: the parameters of a structure from strains, displacements, mass and natural frequencies."""

from femlib.calibration.design import Design, ParametricStructure
from femlib.calibration.fit import Calibration, calibrate
from femlib.calibration.moving_gauges import MovingGauges
from femlib.calibration.observation import FrequencyReading, MassReading, Observation, OutputReading
from femlib.calibration.parameter import Parameter
from femlib.calibration.prediction import Prediction, predict
from femlib.calibration.varying import Varying, VaryingRows

__all__ = [
    "Calibration",
    "Design",
    "FrequencyReading",
    "MassReading",
    "MovingGauges",
    "Observation",
    "OutputReading",
    "Parameter",
    "ParametricStructure",
    "Prediction",
    "Varying",
    "VaryingRows",
    "calibrate",
    "predict",
]
