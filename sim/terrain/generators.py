"""Every kind of terrain: its parameters and its shape, one class a kind.

Shapes are functions of the place and the seed alone, never of the map's size: a longer course finds
the same ground. Features lie in the absolute frame; ``at`` is the distance from the origin to their
near edge along +x, or along ``heading_deg`` where a kind has one. ``difficulty`` 0-1 sets the
parameters a kind lists in ``RAMP``; explicit ones win.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, PlainValidator, model_validator
from pydantic_core import PydanticCustomError

from walking_console.planner.geometry.paths import Box
from walking_console.planner.geometry.transforms import direction, directions, left_fold_sum
from walking_console.planner.terrain.map import EDGE
from walking_console.planner.types import Array

from ..tables import Bearing, Extent, MapMetres, Table

SMOOTH_CELL = 0.025  # m: smooth ground is resampled to cells no larger than this
CELL_MIN, CELL_MAX = 0.005, 1.0  # m
ROWS_MAX = 2000  # of heights in a scenario, and of heights in each
SEED_MAX = 2**63 - 1
PATCHES_MAX = 200  # of ground that gives way

MapSide = Annotated[float, Field(gt=0.0, le=2000.0)]  # m
CellSize = Annotated[float, Field(ge=CELL_MIN, le=10_000.0)]


class GroundError(ValueError):
    """Ground that cannot be made; the message is one clear line."""


@dataclass(frozen=True, slots=True)
class Obstacle:
    """Something that stands up from the ground between ``base`` and ``top``: a circle, or a convex
    polygon.

    ``corners`` run counter-clockwise in the absolute frame; a circle has none and a ``radius``
    instead.
    """

    x: float
    y: float
    base: float  # m, absolute
    top: float  # m, absolute
    radius: float = 0.0
    corners: tuple[tuple[float, float], ...] = ()


class Site(NamedTuple):
    """Where a shape is wanted: cell centres as a row ``x`` (1, nx) and a column ``y`` (ny, 1), and
    the start to keep clear.
    """

    x: Array
    y: Array
    cell: float
    bounds: Box
    start: tuple[float, float]
    clear: float  # m, radius
    seed: int


class LoosePatch(Table):
    """A rectangle of ground that goes down, whole and at once, when a foot presses too hard on
    it.
    """

    x: Annotated[list[MapMetres], Field(min_length=2, max_length=2)]  # m, absolute, from and to
    y: Annotated[list[MapMetres], Field(min_length=2, max_length=2)]  # m, absolute, from and to
    sinks: float = Field(default=0.1, gt=0.0, le=2.0)  # m it goes down
    bears: float = Field(default=0.0, ge=0.0, le=1e6)  # N of one foot that it bears

    @model_validator(mode="after")
    def _has_an_extent(self) -> LoosePatch:
        for name, (low, high) in (("x", self.x), ("y", self.y)):
            if not low < high:
                raise PydanticCustomError(
                    "extent", "{name} needs two numbers, the lesser first", {"name": name}
                )
        return self


class Terrain(Table):
    """What every kind has."""

    kind: str
    seed: int | None = Field(
        default=None, ge=0, le=SEED_MAX, description="the scenario's seed when not given"
    )
    edge: float = Field(
        default=EDGE, ge=0.0, le=0.1, description="m a foothold keeps from bottomless cells"
    )
    gives_way: list[LoosePatch] = Field(
        default=[],
        max_length=PATCHES_MAX,
        description="patches that go down when a foot presses on them with more than they bear",
    )


class Generated(Terrain):
    """Ground that is computed, in a map as large as the course needs, or larger."""

    # parameter: value at difficulty 0, at difficulty 1
    RAMP: ClassVar[dict[str, tuple[float, float]]] = {}
    final: ClassVar[bool] = False  # forbidden cells are exactly the holes
    clears_start: ClassVar[bool] = False  # level ground is kept under the start posture

    difficulty: float | None = Field(
        default=None, ge=0.0, le=1.0, description="0 easy to 1 hard; explicit parameters win"
    )
    cell: float = Field(default=SMOOTH_CELL, ge=CELL_MIN, le=SMOOTH_CELL, description="m")
    map_size: Annotated[list[MapSide], Field(min_length=2, max_length=2)] | None = Field(
        default=None,
        description="m along x and y the map reaches about the start, at least; as large as the "
        "course needs when not given",
    )

    @model_validator(mode="before")
    @classmethod
    def _by_difficulty(cls, data: Any) -> Any:
        """Parameters not given follow from the difficulty, so that a dump holds plain numbers."""
        if not isinstance(data, dict):
            return data
        level = data.get("difficulty")
        if isinstance(level, bool) or not isinstance(level, int | float) or not 0 <= level <= 1:
            return data
        ramp = {key: easy + (hard - easy) * level for key, (easy, hard) in cls.RAMP.items()}
        whole = [key for key, field in cls.model_fields.items() if field.annotation is int]
        return {
            **{
                key: round(value) if key in whole else round(value, 6)
                for key, value in ramp.items()
            },
            **data,
        }

    def shape(self, site: Site) -> Array:
        """Heights in metres at the site's cells, or what broadcasts to them; NaN is a hole."""
        return np.zeros((1, 1))

    def obstacles(self, site: Site) -> tuple[Obstacle, ...]:
        """What stands on this ground."""
        return ()


class Flat(Generated):
    """Level ground."""

    kind: Literal["flat"]
    cell: float = Field(
        default=0.05,
        ge=CELL_MIN,
        le=CELL_MAX,
        description="m; grows on very long courses, level ground is exact anyway",
    )


class Slope(Generated):
    """One inclined plane through the origin."""

    RAMP = {"angle_deg": (2.0, 14.0)}
    kind: Literal["slope"]
    angle_deg: float = Field(
        default=8.0, ge=-45.0, le=45.0, description="inclination, rising along the heading"
    )
    heading_deg: Bearing = Field(default=0.0, description="direction of steepest ascent")

    def shape(self, site: Site) -> Array:
        return np.asarray(math.tan(math.radians(self.angle_deg)) * _along(site, self.heading_deg))


class Rough(Generated):
    """Smooth random hills: a sum of plane waves, clipped at the amplitude."""

    RAMP = {"amplitude": (0.01, 0.11)}
    WAVES: ClassVar[int] = 32
    kind: Literal["rough"]
    amplitude: float = Field(
        default=0.06, ge=0.0, le=1.0, description="m, highest and lowest ground above and below 0"
    )
    length: float = Field(
        default=1.0,
        ge=0.2,
        le=20.0,
        description="m, shortest wavelength; the longest is four times that",
    )

    def shape(self, site: Site) -> Array:
        rng = np.random.default_rng([site.seed, 1])
        heading, phase = (
            rng.uniform(0.0, 2 * math.pi, self.WAVES),
            rng.uniform(0.0, 2 * math.pi, self.WAVES),
        )
        # one by one: what numpy makes of a power depends on the processor it runs on
        longer = np.array([math.pow(4.0, u) for u in rng.uniform(0.0, 1.0, self.WAVES).tolist()])
        wave = 2 * math.pi / (self.length * longer)
        heights = np.zeros((site.y.size, site.x.size))
        for k, a, p in zip(wave, heading, phase, strict=True):
            c, s = direction(a)
            along_x, along_y = directions(k * c * site.x + p), directions(k * s * site.y)
            # sin(u + v), an axis at a time
            heights += along_x[1] * along_y[0] + along_x[0] * along_y[1]
        # the standard deviation is half the amplitude
        heights *= self.amplitude / 2 / math.sqrt(self.WAVES / 2)
        return np.clip(heights, -self.amplitude, self.amplitude)


class Wave(Generated):
    """Parallel ridges and furrows, A(1 - cos(2πs/L)); the origin lies in a furrow."""

    RAMP = {"amplitude": (0.02, 0.12)}
    kind: Literal["wave"]
    amplitude: float = Field(
        default=0.06, ge=0.0, le=1.0, description="m, half the height from furrow to ridge"
    )
    length: float = Field(default=2.0, ge=0.2, le=100.0, description="m, ridge to ridge")
    heading_deg: Bearing = Field(default=0.0, description="direction across the ridges")

    def shape(self, site: Site) -> Array:
        return np.asarray(
            self.amplitude
            * (1.0 - np.cos(2 * math.pi / self.length * _along(site, self.heading_deg)))
        )


class Stairs(Generated):
    """A flight of stairs across the whole map, up, down, or up and down again."""

    RAMP = {"rise": (0.05, 0.25)}
    kind: Literal["stairs"]
    rise: float = Field(default=0.15, gt=0.0, le=1.0, description="m")
    tread: float = Field(default=0.6, ge=0.05, le=10.0, description="m")
    count: int = Field(default=3, ge=1, le=100, description="steps of one flight")
    direction: Literal["up", "down", "up-down"] = Field(
        default="up", description="up, down, or up-down"
    )
    landing: Extent = Field(default=1.5, description="m of level ground on top between up and down")
    at: MapMetres = Field(default=1.2, description="m to the first edge")
    heading_deg: Bearing = Field(default=0.0, description="direction of walking up the flight")

    def _edges(self) -> list[tuple[float, float]]:
        """(distance of an edge, change of height there), in order."""
        rise = -self.rise if self.direction == "down" else self.rise
        edges = [(self.at + step * self.tread, rise) for step in range(self.count)]
        if self.direction == "up-down":
            top = edges[-1][0] + self.landing
            edges += [(top + step * self.tread, -self.rise) for step in range(self.count)]
        return edges

    def shape(self, site: Site) -> Array:
        along = _along(site, self.heading_deg)
        heights = np.zeros(along.shape)
        for edge, rise in self._edges():
            heights[along >= edge] += rise
        return np.asarray(np.round(heights, 9))

    def obstacles(self, site: Site) -> tuple[Obstacle, ...]:
        edges = self._edges()
        # beyond the map whatever the heading
        far = math.hypot(max(abs(v) for v in site.bounds[:2]), max(abs(v) for v in site.bounds[2:]))
        places = [-far, *(edge for edge, _ in edges), far]
        tops = [0.0]
        for _, rise in edges:
            tops.append(round(tops[-1] + rise, 9))
        boxes = []
        for index, top in enumerate(tops):
            base = min(tops[max(0, index - 1) : index + 2])
            if top > base:
                boxes.append(
                    _box(places[index], places[index + 1], -far, far, self.heading_deg, base, top)
                )
        return tuple(boxes)


class Patch(Generated):
    """A rectangle on level ground."""

    length: Extent = Field(default=1.2, description="m along x, before turning")
    width: Extent = Field(default=1.6, description="m along y, before turning")
    at: MapMetres = Field(default=1.4, description="m along x to the near side, before turning")
    aside: MapMetres = Field(default=0.0, description="m along y to the middle")
    angle_deg: Bearing = Field(default=0.0, description="turned about its own middle")

    @property
    def middle(self) -> tuple[float, float]:
        return self.at + self.length / 2, self.aside

    def inside(self, site: Site) -> NDArray[np.bool_]:
        c, s = quarter_direction(self.angle_deg)
        dx, dy = site.x - self.middle[0], site.y - self.middle[1]
        u, v = c * dx + s * dy, c * dy - s * dx
        return np.asarray((abs(u) <= self.length / 2) & (abs(v) <= self.width / 2))


class Block(Patch):
    """One block on level ground."""

    RAMP = {"height": (0.04, 0.26)}
    kind: Literal["block"]
    height: float = Field(default=0.15, gt=0.0, le=3.0, description="m")

    def shape(self, site: Site) -> Array:
        return np.where(self.inside(site), self.height, 0.0)

    def obstacles(self, site: Site) -> tuple[Obstacle, ...]:
        half_length, half_width = self.length / 2, self.width / 2
        return (
            _box(
                -half_length,
                half_length,
                -half_width,
                half_width,
                self.angle_deg,
                0.0,
                self.height,
                self.middle,
            ),
        )


class Pit(Patch):
    """One hollow with a level floor."""

    RAMP = {"depth": (0.04, 0.26)}
    kind: Literal["pit"]
    depth: float = Field(default=0.15, gt=0.0, le=3.0, description="m")

    def shape(self, site: Site) -> Array:
        return np.where(self.inside(site), -self.depth, 0.0)


class River(Generated):
    """A bottomless strip across the whole map."""

    RAMP = {"width": (0.1, 0.6)}
    kind: Literal["river"]
    width: Extent = Field(default=0.35, description="m")
    at: MapMetres = Field(default=1.2, description="m to the near bank")
    heading_deg: Bearing = Field(default=0.0, description="direction square to the banks")

    def shape(self, site: Site) -> Array:
        along = _along(site, self.heading_deg)
        return np.where((along > self.at) & (along < self.at + self.width), math.nan, 0.0)


class Gap(Generated):
    """Bottomless gaps across the whole map, one behind the other, between ledges of different
    heights.
    """

    RAMP = {"width": (0.1, 0.4), "drop": (0.0, 0.16)}
    kind: Literal["gap"]
    width: Extent = Field(default=0.25, description="m")
    count: int = Field(default=3, ge=1, le=100, description="gaps")
    spacing: Extent = Field(default=1.5, description="m from one gap's near edge to the next one's")
    drop: float = Field(
        default=0.08, ge=-1.0, le=1.0, description="m every second ledge lies lower"
    )
    at: MapMetres = Field(default=1.2, description="m to the first gap")
    heading_deg: Bearing = Field(default=0.0, description="direction square to the gaps")

    def shape(self, site: Site) -> Array:
        along = _along(site, self.heading_deg)
        heights = np.zeros(along.shape)
        for index in range(self.count):
            edge = self.at + index * self.spacing
            heights[along > edge + self.width / 2] = -self.drop if index % 2 == 0 else 0.0
        for index in range(self.count):
            edge = self.at + index * self.spacing
            heights[(along > edge) & (along < edge + self.width)] = math.nan
        return heights


class Holes(Generated):
    """Bottomless cells at random: H's H-type terrain. Only the cell under the foot tip counts."""

    RAMP = {"fraction": (0.05, 0.55)}
    final = True
    clears_start = True
    kind: Literal["holes"]
    fraction: float = Field(
        default=0.3, ge=0.0, le=1.0, description="share of the cells that are holes"
    )
    cell: float = Field(default=0.05, ge=CELL_MIN, le=CELL_MAX, description="m")
    large: list[Annotated[list[MapMetres], Field(min_length=4, max_length=4)]] = Field(
        default=[], max_length=100, description="m, x_min, x_max, y_min, y_max of each large hole"
    )

    def shape(self, site: Site) -> Array:
        heights = np.where(_lattice(site, site.cell, 2) < self.fraction, math.nan, 0.0)
        for x_min, x_max, y_min, y_max in self.large:
            heights[(site.x > x_min) & (site.x < x_max) & (site.y > y_min) & (site.y < y_max)] = (
                math.nan
            )
        return heights


class Footholds(Generated):
    """Only a few cells may be stepped on, all others are bottomless: K's terrain. Foothold points
    are cell centres.
    """

    RAMP = {"fraction": (0.2, 0.02)}
    final = True
    clears_start = True
    kind: Literal["footholds"]
    fraction: float = Field(
        default=0.04, ge=0.0, le=1.0, description="share of the cells that are allowed"
    )
    cell: float = Field(default=0.05, ge=CELL_MIN, le=CELL_MAX, description="m")

    def shape(self, site: Site) -> Array:
        return np.where(_lattice(site, site.cell, 3) < self.fraction, 0.0, math.nan)


class SteppingStones(Generated):
    """Square stones in rows over the bottomless."""

    RAMP = {"size": (0.45, 0.25), "spacing": (0.05, 0.2), "jitter": (0.0, 0.08)}
    clears_start = True
    kind: Literal["stepping_stones"]
    size: Extent = Field(default=0.35, description="m, side of a stone")
    spacing: float = Field(default=0.125, ge=0.0, le=10.0, description="m between two stones")
    jitter: float = Field(
        default=0.04,
        ge=0.0,
        le=1.0,
        description="m, stones lie at random up to this much above or below 0",
    )

    def shape(self, site: Site) -> Array:
        pitch = self.size + self.spacing
        on_x = np.mod(site.x + self.size / 2, pitch) < self.size
        on_y = np.mod(site.y + self.size / 2, pitch) < self.size
        heights = self.jitter * (2.0 * _lattice(site, pitch, 4, self.size / 2) - 1.0)
        return np.where(on_x & on_y, heights, math.nan)


class Poles(Generated):
    """Round poles at random in an area ahead of the origin."""

    RAMP = {"count": (4, 40)}
    clears_start = True
    kind: Literal["poles"]
    count: int = Field(default=16, ge=0, le=500, description="poles")
    radius: float = Field(default=0.05, ge=0.01, le=1.0, description="m")
    height: float = Field(default=0.5, gt=0.0, le=3.0, description="m")
    spacing: float = Field(
        default=0.25, ge=0.0, le=10.0, description="m of free ground between two poles"
    )
    area: Annotated[list[MapMetres], Field(min_length=4, max_length=4)] = Field(
        default=[1.2, 8.0, -2.0, 2.0],
        description="m, x_min, x_max, y_min, y_max of the ground they stand on",
    )

    @model_validator(mode="after")
    def _area_is_a_rectangle(self) -> Poles:
        x_min, x_max, y_min, y_max = self.area
        if not (x_min < x_max and y_min < y_max):
            raise ValueError(
                "area must be [x_min, x_max, y_min, y_max] with x_min < x_max and y_min < y_max, "
                f"got {self.area}"
            )
        return self

    def centres(self, site: Site) -> tuple[tuple[float, float], ...]:
        """Where the poles stand, outside the start's clearing; the area may be too small for all of
        them.
        """
        x_min, x_max, y_min, y_max = self.area
        return _pole_centres(
            self.count,
            self.radius,
            self.spacing,
            (x_min, x_max, y_min, y_max),
            (site.start, site.clear, site.seed),
        )

    def shape(self, site: Site) -> Array:
        heights = np.zeros((site.y.size, site.x.size))
        wide = max(self.radius, 0.75 * site.cell)
        for px, py in self.centres(site):
            c0, c1 = _span(px, wide + site.cell, site.x[0])
            r0, r1 = _span(py, wide + site.cell, site.y[:, 0])
            patch = heights[r0:r1, c0:c1]
            patch[np.hypot(site.x[:, c0:c1] - px, site.y[r0:r1] - py) <= wide] = self.height
        return heights

    def obstacles(self, site: Site) -> tuple[Obstacle, ...]:
        return tuple(Obstacle(x, y, 0.0, self.height, self.radius) for x, y in self.centres(site))


@lru_cache(maxsize=8)
def _pole_centres(
    count: int,
    radius: float,
    spacing: float,
    area: Box,
    place: tuple[tuple[float, float], float, int],
) -> tuple[tuple[float, float], ...]:
    """Where poles stand; ``place`` is the start, its clearing in m and the seed. Kept, as a wide
    map asks for them with every tile.
    """
    start, clear, seed = place
    rng = np.random.default_rng([seed, 5])
    x_min, x_max, y_min, y_max = area
    apart = 2 * radius + spacing
    placed = list[tuple[float, float]]()
    for _ in range(50 * count):
        if len(placed) == count:
            break
        x, y = float(rng.uniform(x_min, x_max)), float(rng.uniform(y_min, y_max))
        is_clear = math.hypot(x - start[0], y - start[1]) > clear + radius
        if is_clear and all(math.hypot(x - px, y - py) >= apart for px, py in placed):
            placed.append((x, y))
    if len(placed) < count:
        raise GroundError(
            f"only {len(placed)} of {count} poles fit; use fewer, less spacing or a larger area"
        )
    return tuple(placed)


class Dem(Generated):
    """A real elevation model at walking scale: the Jacksboro fault, Tennessee; mirrored beyond its
    edges.
    """

    RAMP = {"relief": (3000.0, 1000.0)}
    kind: Literal["dem"]
    scale: float = Field(default=1000.0, ge=10.0, le=1e6, description="horizontal scale 1:scale")
    relief: float = Field(default=2000.0, ge=10.0, le=1e9, description="vertical scale 1:relief")
    offset: Annotated[list[MapMetres], Field(min_length=2, max_length=2)] = Field(
        default=[8.0, 16.0],
        description="m at walking scale, east and north of the model's south-west corner: "
        "what lies at the origin",
    )
    heading_deg: Bearing = Field(
        default=0.0, description="compass direction of +x, counter-clockwise from east"
    )


class MapTerrain(Terrain):
    """Heights that somebody brings: how they are understood."""

    cell: CellSize | Annotated[list[CellSize], Field(min_length=2, max_length=2)] | None = Field(
        default=None, description="m, one number or [x, y]; the file's own, else 0.05"
    )
    scale: float = Field(
        default=1.0,
        ge=-1000.0,
        le=1000.0,
        description="m for white in a picture, a factor otherwise (of all three axes of a mesh)",
    )
    offset: Annotated[float, Field(ge=-1e5, le=1e5)] | Literal["min", "start"] | None = Field(
        default=None,
        description='m taken off every height; "min": the lowest, "start": that of the start; '
        "by itself where heights are more than 10 m from 0",
    )
    nodata: float | None = Field(
        default=None, description="the height that stands for none; the file's own when not given"
    )
    flip: Literal["x", "y", "xy"] | None = Field(
        default=None, description="mirror the map along an axis"
    )
    step: int = Field(default=1, ge=1, le=1000, description="take every so many cells")
    crop: Annotated[list[MapMetres], Field(min_length=4, max_length=4)] | None = Field(
        default=None, description="keep only [x_min, x_max, y_min, y_max], m"
    )
    origin: Annotated[list[MapMetres], Field(min_length=2, max_length=2)] | None = Field(
        default=None,
        description="x, y of the corner of the cell of least x and y; the map's middle lies at the "
        "origin, or the .npz file's own",
    )
    nan: Literal["hole"] | None = Field(
        default=None,
        description='"hole": NaN and NODATA are holes without a bottom; refused otherwise',
    )
    smooth: bool = Field(default=False, description="interpolate to cells of at most 0.025 m")
    final: bool = Field(default=False, description="only the cell under the foot tip counts")


class FileTerrain(MapTerrain):
    """Heights from a file: PNG (JPEG, BMP, PGM, PPM), TIFF and GeoTIFF, ESRI ASCII grid (.asc),
    Surfer grid (.grd), CSV matrix or point list, .npy, .npz (a run's own terrain.npz), STL, PLY
    and OBJ.

    Pictures and grids are north up: the first row is the largest y. Arrays (.npy, .npz) have the
    row of least y first.
    """

    kind: Literal["file"]
    file: str = Field(
        min_length=1, max_length=500, description="path, relative to the scenario file"
    )
    up: Literal["y", "z"] | None = Field(
        default=None,
        description="the axis of a mesh that points up; z, and a mesh that looks as if it were y is"
        " refused until it is said",
    )


def _rows(value: Any) -> list[list[float | Literal["hole"]]]:
    """Rows of numbers, "hole" or null; the message names the first that is none of them."""
    if not isinstance(value, list) or not all(isinstance(row, list) for row in value):
        raise _bad_rows("must be an array of rows of numbers")
    widths = {len(row) for row in value}
    if (
        len(widths) != 1
        or not 2 <= min(len(value), *widths) <= max(len(value), *widths) <= ROWS_MAX
    ):
        shown = f"{len(value)} rows of {min(widths, default=0)} to {max(widths, default=0)}"
        raise _bad_rows(
            f"must be 2 to {ROWS_MAX} rows of one length of 2 to {ROWS_MAX}, got {shown}"
        )
    return [[_height(cell, r, c) for c, cell in enumerate(row)] for r, row in enumerate(value)]


def _height(value: Any, row: int, column: int) -> float | Literal["hole"]:
    if value is None or value == "hole":
        return "hole"
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise _bad_rows(f'[{row}, {column}] must be a height in m or "hole", got {value!r:.40}')
    return float(value)


def _bad_rows(what: str) -> PydanticCustomError:
    return PydanticCustomError("heights_rows", "{what}", {"what": what})


class HeightsTerrain(MapTerrain):
    """Heights written into the scenario itself, as rows; the first row is the largest y. "hole", or
    null, is a hole without a bottom.
    """

    kind: Literal["heights"]
    rows: Annotated[list[list[float | Literal["hole"]]], PlainValidator(_rows)] = Field(
        description="heights in m"
    )
    nan: Literal["hole"] = "hole"

    @model_validator(mode="before")
    @classmethod
    def _with_the_unit_in_the_key(cls, data: Any) -> Any:
        if not isinstance(data, dict) or "cell_m" not in data or "cell" in data:
            return data
        return _renamed(data)


def _renamed(data: dict[str, Any]) -> dict[str, Any]:
    """``cell_m`` is ``cell``, as keys over HTTP have their unit."""
    return {("cell" if key == "cell_m" else key): value for key, value in data.items()}


AnyTerrain = Annotated[
    Flat
    | Slope
    | Rough
    | Stairs
    | Block
    | River
    | Holes
    | Footholds
    | Poles
    | Gap
    | Pit
    | SteppingStones
    | Wave
    | Dem
    | FileTerrain
    | HeightsTerrain,
    Field(discriminator="kind"),
]
KINDS: dict[str, type[Terrain]] = {
    "flat": Flat,
    "slope": Slope,
    "rough": Rough,
    "stairs": Stairs,
    "block": Block,
    "river": River,
    "holes": Holes,
    "footholds": Footholds,
    "poles": Poles,
    "gap": Gap,
    "pit": Pit,
    "stepping_stones": SteppingStones,
    "wave": Wave,
    "dem": Dem,
    "file": FileTerrain,
    "heights": HeightsTerrain,
}


def list_terrains() -> tuple[tuple[str, str], ...]:
    """Every kind with one line: what it is and the parameters it takes."""
    return tuple((kind, _one_line(model)) for kind, model in KINDS.items())


def _one_line(model: type[Terrain]) -> str:
    words = (model.__doc__ or "").strip().splitlines()[0]
    shared = {
        name
        for name, field in Generated.model_fields.items()
        if field == model.model_fields.get(name)
    }
    own = [
        name for name in model.model_fields if name not in shared | {"kind", "seed", "difficulty"}
    ]
    return f"{words} ({', '.join(own)})" if own else words


def quarter_direction(angle_deg: float) -> tuple[float, float]:
    """cos and sin, exact at quarter turns: a river square to the course has straight banks."""
    quarter, rest = divmod(angle_deg, 90.0)
    if rest == 0.0:
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarter) % 4]
    return direction(math.radians(angle_deg))


def _along(site: Site, heading_deg: float) -> Array:
    """Distance of every cell from the origin along the heading."""
    c, s = quarter_direction(heading_deg)
    return np.asarray(c * site.x + s * site.y)


def _box(
    u0: float,
    u1: float,
    v0: float,
    v1: float,
    angle_deg: float,
    base: float,
    top: float,
    middle: tuple[float, float] = (0.0, 0.0),
) -> Obstacle:
    """The rectangle [u0, u1] x [v0, v1] turned about the origin, then carried to ``middle``."""
    c, s = quarter_direction(angle_deg)
    corners = tuple(
        (middle[0] + c * u - s * v, middle[1] + s * u + c * v)
        for u, v in ((u0, v0), (u1, v0), (u1, v1), (u0, v1))
    )
    return Obstacle(
        left_fold_sum(p[0] for p in corners) / 4,
        left_fold_sum(p[1] for p in corners) / 4,
        base,
        top,
        0.0,
        corners,
    )


def _span(centre: float, reach: float, places: Array) -> tuple[int, int]:
    """The range of cells a circle may touch, of those at these rising places."""
    first, last = np.searchsorted(places, (centre - reach, centre + reach))
    return int(first), int(last)


def _lattice(site: Site, pitch: float, salt: int, shift: float = 0.0) -> Array:
    """A number in [0, 1) for the lattice square each cell lies in: a hash of its place and the seed
    (splitmix64).
    """
    i = np.floor((site.x + shift) / pitch).astype(np.int64).astype(np.uint64)
    j = np.floor((site.y + shift) / pitch).astype(np.int64).astype(np.uint64)
    start = np.full((1, 1), (site.seed * 0x9E3779B97F4A7C15 + salt) % 2**64, dtype=np.uint64)
    mixed = _splitmix(_splitmix(_splitmix(start) + i) + j)
    return np.asarray((mixed >> np.uint64(11)).astype(np.float64) * 2.0**-53)


def _splitmix(value: NDArray[np.uint64]) -> NDArray[np.uint64]:
    value = value + np.uint64(0x9E3779B97F4A7C15)
    value = (value ^ (value >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    value = (value ^ (value >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return value ^ (value >> np.uint64(31))
