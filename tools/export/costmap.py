"""A 2D semantic costmap for navigation, as ROS's map_server loads it.

``map.yaml`` and ``map.png``: free (white) where floor was seen, occupied (black) where something
stands between the robot's wheels and its top, unknown (grey) else; image row 0 is the largest y
(http://wiki.ros.org/map_server). ``semantic.png`` (uint16, same grid) has the instance that
occupies each cell, ``semantic.json`` what each is.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml

from sceneq_core.arrays import Float64, Int32, Int64, UInt8
from sceneq_core.mapping.delta import CEILING, FLOOR
from sceneq_tools.errors import UserError
from sceneq_tools.export.scene import ExportedScene
from sceneq_tools.export.upright import R_target_world, is_level, unit

FREE, OCCUPIED, UNKNOWN = 254, 0, 205
OCCUPIED_THRESH, FREE_THRESH = 0.65, 0.196
Z_AXIS = np.array([0.0, 0.0, 1.0])
MAX_CELLS = 64_000_000


@dataclass(frozen=True, slots=True)
class CostmapParams:
    """``resolution_m`` of a cell; what is ``over_floor_m`` to ``clearance_m`` high is in the way.

    A cell is occupied from ``min_points`` in that band.
    """

    resolution_m: float = 0.05
    over_floor_m: float = 0.08
    clearance_m: float = 1.6
    min_points: int = 3


@dataclass(frozen=True, slots=True)
class Grid:
    """Cells (H, W) over the ground: ``origin_m`` (x, y) is the lower left corner of the lowest."""

    origin_m: tuple[float, float]
    resolution_m: float
    shape: tuple[int, int]

    def cell(self, points_map: Float64) -> Int64:
        """Return the flat number of the cell of every point (N, 3): row 0 is the smallest y."""
        xy = (points_map[:, :2] - self.origin_m) / self.resolution_m
        column, row = np.floor(xy).astype(np.int64).T
        return np.asarray(row * self.shape[1] + column, np.int64)


def write_costmap(
    scene: ExportedScene, out: Path, params: CostmapParams = CostmapParams()
) -> list[Path]:
    """Write the four files; raise ``UserError`` for a map that is empty or too large."""
    if not len(scene.cloud.points_world):
        raise UserError("costmap: the map is empty")
    R_map_world = level_frame(np.asarray(scene.cloud.up_world))
    points_map = scene.cloud.points_world @ R_map_world.T
    grid = grid_over(points_map, params.resolution_m)
    roles = {record["id"]: record.get("role", "object") for record in scene.records}
    cost, semantic = costs(points_map, scene.cloud.instance_id, roles, grid, params)
    return _write(scene, out, grid, R_map_world, cost, semantic)


def level_frame(up_world: Float64) -> Float64:
    """Return R_map_world (3, 3): the world itself when its z axis is up."""
    up = unit(up_world)
    return np.eye(3) if is_level(up, Z_AXIS) else R_target_world(up, Z_AXIS)


def grid_over(points_map: Float64, resolution_m: float) -> Grid:
    """Return the grid that holds all points (N, 3), its origin a multiple of the resolution."""
    low = np.floor(points_map[:, :2].min(0) / resolution_m)
    count = np.floor(points_map[:, :2].max(0) / resolution_m) - low + 1
    if count.prod() > MAX_CELLS:
        raise UserError(f"costmap: {count[0]:.0f} x {count[1]:.0f} cells are too many", 2)
    x, y = (low * resolution_m).tolist()
    return Grid((x, y), resolution_m, (int(count[1]), int(count[0])))


def costs(
    points_map: Float64,
    instance_id: Int32,
    roles: dict[int, str],
    grid: Grid,
    params: CostmapParams,
) -> tuple[UInt8, Int32]:
    """Return what map.png and semantic.png hold (H, W), row 0 the smallest y."""
    is_floor = _has_role(instance_id, roles, FLOOR)
    height = points_map[:, 2] - floor_height(points_map, is_floor)
    low, high = params.over_floor_m, params.clearance_m
    in_way = (height > low) & (height < high) & ~_has_role(instance_id, roles, CEILING)
    size, cell = grid.shape[0] * grid.shape[1], grid.cell(points_map)
    blocked = np.bincount(cell[in_way], minlength=size) >= params.min_points
    free = np.bincount(cell[np.abs(height) <= low], minlength=size) > 0
    cost = np.where(blocked, OCCUPIED, np.where(free, FREE, UNKNOWN)).astype(np.uint8)
    semantic = np.where(blocked, _most_common(cell[in_way], instance_id[in_way], size), 0)
    return cost.reshape(grid.shape), semantic.astype(np.int32).reshape(grid.shape)


def floor_height(points_map: Float64, is_floor: Any) -> float:
    """Return the height of the floor: the median of its points, else the lowest of the map."""
    if is_floor.any():
        return float(np.median(points_map[is_floor, 2]))
    return float(np.percentile(points_map[:, 2], 1))


def _has_role(instance_id: Int32, roles: dict[int, str], role: str) -> Any:
    return np.isin(instance_id, [number for number, its in roles.items() if its == role])


def _most_common(cell: Int64, instance_id: Int32, size: int) -> Int64:
    """Return the instance with most points in every cell (size,), 0 where there are none."""
    pair, count = np.unique(np.stack([cell, instance_id]), axis=1, return_counts=True)
    winner = np.zeros(size, np.int64)
    order = np.argsort(count, kind="stable")  # the most frequent is written last
    winner[pair[0, order]] = pair[1, order]
    return winner


def _write(
    scene: ExportedScene,
    out: Path,
    grid: Grid,
    R_map_world: Float64,
    cost: UInt8,
    semantic: Int32,
) -> list[Path]:
    folder = out / "costmap"
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / n for n in ("map.yaml", "map.png", "semantic.png", "semantic.json")]
    ids = [number for number in np.unique(semantic).tolist() if number]
    known = {r["id"]: {"id": r["id"], "label": r.get("label")} for r in scene.records}
    number = {instance: place for place, instance in enumerate(ids, 1)}
    legend = {str(number[i]): known.get(i, {"id": i, "label": None}) for i in ids}
    cells = np.vectorize(lambda i: number.get(i, 0), otypes=[np.uint16])(semantic)
    paths[0].write_text(yaml.safe_dump(_settings(grid), sort_keys=False))
    cv2.imwrite(str(paths[1]), cost[::-1])
    cv2.imwrite(str(paths[2]), cells[::-1])
    about = {"scene": scene.name, "R_map_world": R_map_world.tolist(), "cells": legend}
    paths[3].write_text(json.dumps(about, indent=1, ensure_ascii=False))
    return paths


def _settings(grid: Grid) -> dict[str, Any]:
    return {
        "image": "map.png",
        "mode": "trinary",
        "resolution": grid.resolution_m,
        "origin": [*grid.origin_m, 0.0],
        "negate": 0,
        "occupied_thresh": OCCUPIED_THRESH,
        "free_thresh": FREE_THRESH,
    }
