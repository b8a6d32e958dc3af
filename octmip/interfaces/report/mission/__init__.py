"""A mission of a monitored asset as a page: what was read, believed, decided and found, step by step."""

from octmip.interfaces.report.mission.page import mission_page
from octmip.interfaces.report.mission.record import Course, MissionStep, Region

__all__ = ["Course", "MissionStep", "Region", "mission_page"]
