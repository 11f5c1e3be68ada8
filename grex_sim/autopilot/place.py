"""Where on earth the craft started; the only user of pymap3d here."""

import msgspec
import pymap3d


class Place(msgspec.Struct, frozen=True):
    """The start: origin of the NED frame that nobody on the link ever sees."""

    latitude_deg: float
    longitude_deg: float

    def globe(self, north_m: float, east_m: float) -> tuple[float, float]:
        """Latitude and longitude, degrees, of a place in the frame."""
        latitude, longitude, _ = pymap3d.ned2geodetic(north_m, east_m, 0.0, self.latitude_deg, self.longitude_deg, 0.0)
        return float(latitude), float(longitude)

    def local(self, latitude_deg: float, longitude_deg: float) -> tuple[float, float]:
        """North and east, metres, of a place on the globe."""
        north, east, _ = pymap3d.geodetic2ned(
            latitude_deg, longitude_deg, 0.0, self.latitude_deg, self.longitude_deg, 0.0
        )
        return float(north), float(east)
