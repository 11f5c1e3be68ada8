"""From degrees to the mission frame and back: NED about the datum (WGS 84). Only here is pymap3d used aboard."""

import math

import pymap3d

from grex_link.config import DatumConfig

_EARTH_RADIUS_M = 6_371_000.0


def to_mission(datum: DatumConfig, latitude_deg: float, longitude_deg: float) -> tuple[float, float]:
    """North and east of a place, metres about the datum. Heights do not matter: all are taken at the ellipsoid."""
    north, east, _ = pymap3d.geodetic2ned(
        latitude_deg, longitude_deg, 0.0, datum.latitude_deg, datum.longitude_deg, 0.0
    )
    return float(north), float(east)


def to_degrees(datum: DatumConfig, north_m: float, east_m: float) -> tuple[float, float]:
    """Latitude and longitude of a place in the mission frame, degrees."""
    latitude, longitude, _ = pymap3d.ned2geodetic(north_m, east_m, 0.0, datum.latitude_deg, datum.longitude_deg, 0.0)
    return float(latitude), float(longitude)


def distance_m(datum: DatumConfig, latitude_deg: float, longitude_deg: float) -> float:
    """Way along the earth, a sphere, from the datum to a place, metres; true on the other side of the earth as well."""
    here, there = math.radians(datum.latitude_deg), math.radians(latitude_deg)
    half_east = math.radians(longitude_deg - datum.longitude_deg) / 2.0
    half_chord_sq = math.sin((there - here) / 2.0) ** 2 + math.cos(here) * math.cos(there) * math.sin(half_east) ** 2
    return 2.0 * _EARTH_RADIUS_M * math.asin(min(math.sqrt(half_chord_sq), 1.0))


def say_distance(distance_m: float) -> str:
    """Say a distance to a person: whole metres, or kilometres of three digits."""
    return f"{distance_m:.0f} m" if distance_m < 1000.0 else f"{float(f'{distance_m / 1e3:.3g}'):g} km"
