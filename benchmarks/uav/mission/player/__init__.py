"""A mission of a monitored asset as a page: what was read, believed, decided and found, step by step."""

from benchmarks.uav.mission.player.page import mission_page
from benchmarks.uav.mission.player.record import Course, MissionStep, Region

__all__ = ["Course", "MissionStep", "Region", "mission_page"]
