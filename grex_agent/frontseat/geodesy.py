"""From degrees to the mission frame and back: NED about the datum (WGS 84). Only here is pymap3d used aboard."""

import pymap3d

from grex_link.config import DatumConfig


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
