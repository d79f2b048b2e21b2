"""A person with a camera who wants to see everything, again and again."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_tools.room.camera.floor_plan import Ways
from sceneq_tools.room.camera.hand_tremor import HandTremor, TremorParams
from sceneq_tools.room.camera.lookout import Lookout, Viewpoint, looking
from sceneq_tools.room.camera.pace import Glide, Pace

MEMORY_S = 45.0
"""After this time what was seen is worth a new look, to one part in e."""
PAN_DEG = 8.0
LEAST_GAIN = 1e-3
"""Where everything is fresh, whatever is near is worth a look."""
CREDITS = 4
"""So many glances on the way from one viewpoint to the next count as seeing too."""


@dataclass(frozen=True, slots=True)
class Stance:
    """Where the walker is: floor position (2,) metres, eye height, directions in radians."""

    xy: Float64
    eye_m: float
    yaw: float
    pitch: float

    def pose(self) -> Float64:
        """Return T_world_camera (4, 4) of a hand that does not tremble."""
        return looking(np.array([*self.xy, self.eye_m]), self.yaw, self.pitch)


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """A way (M, 2) from one stance to the next, then a look around there.

    ``turn`` is the signed change of yaw on the way, ``pan`` the largest one of the look.
    """

    start: Stance
    end: Stance
    way: Float64
    mileage_m: Float64
    turn: float
    pan: float
    glide: Glide
    look: Glide

    @property
    def duration_s(self) -> float:
        """How long way and look take."""
        return self.glide.duration_s + self.look.duration_s

    def walked_m(self, time_s: float) -> float:
        """Return how far the walker is at this time."""
        return self.glide.progress(time_s) * float(self.mileage_m[-1])

    def stance(self, time_s: float) -> Stance:
        """Return where the walker is and looks at this time."""
        done = self.glide.progress(time_s)
        a, b, mileage_m = self.start, self.end, self.walked_m(time_s)
        x, y = (np.interp(mileage_m, self.mileage_m, self.way[:, k]) for k in (0, 1))
        aside = np.sin(2 * np.pi * self.look.progress(time_s - self.glide.duration_s))
        return Stance(
            xy=np.array([x, y]),
            eye_m=a.eye_m + done * (b.eye_m - a.eye_m),
            yaw=a.yaw + done * self.turn + self.pan * float(aside),
            pitch=a.pitch + done * (b.pitch - a.pitch),
        )


class Patrol:
    """Chooses what to look at next: much that was not seen for long, soon reached.

    ``lookout`` may be replaced when the room has changed; the present leg is walked to its end.
    """

    def __init__(
        self,
        lookout: Lookout,
        rate_hz: float,
        seed: int,
        pace: Pace | None = None,
        tremor: TremorParams | None = None,
    ) -> None:
        """Start at the viewpoint that shows most.

        Raises:
            ValueError: ``rate_hz`` not positive, or a pace that the tremor alone exceeds.
        """
        if not rate_hz > 0:
            raise ValueError(f"rate_hz: expected more than 0, got {rate_hz}")
        self.lookout = lookout
        self._pace = pace or Pace()
        self._rate_hz = rate_hz
        self._tremor = HandTremor(np.random.default_rng((seed, 2)), tremor)
        self._speed_m_s, self._turn_s = self._what_the_hand_leaves()
        self._seen: dict[int, tuple[float, float]] = {}
        self._wanted: int | None = None

    def attend(self, thing_id: int) -> None:
        """Go and look at this thing next."""
        self._wanted = thing_id

    def poses(self) -> Iterator[Float64]:
        """Yield T_world_camera (4, 4), OpenCV axes, ``rate_hz`` a second, for ever."""
        stance, began_s, walked_m, frame = self._first(), 0.0, 0.0, 0
        self._credit(stance, 0.0)
        while True:
            leg = self._next_leg(stance, began_s)
            while (time_s := frame / self._rate_hz) < began_s + leg.duration_s:
                yield self._held(leg, time_s - began_s, time_s, walked_m)
                frame += 1
            stance, began_s = leg.end, began_s + leg.duration_s
            walked_m += float(leg.mileage_m[-1])

    def _what_the_hand_leaves(self) -> tuple[float, float]:
        """Return the greatest speeds of the walk, m/s and rad/s: the limits hold for the sum."""
        pace = self._pace
        move, turn = self._tremor.top_speed(pace.walk_m_s, pace.ramp_s)
        left = pace.walk_m_s - move, np.radians(pace.turn_deg_s) - turn
        if min(left) <= 0:
            raise ValueError(
                f"pace: the hand alone moves {move:.2f} m/s and turns {np.degrees(turn):.0f} deg/s"
            )
        return left[0], float(left[1])

    def _first(self) -> Stance:
        sums = [float(v.scores.sum()) for v in self.lookout.viewpoints]
        return self._stance(self.lookout.viewpoints[int(np.argmax(sums))])

    def _stance(self, view: Viewpoint) -> Stance:
        return Stance(self.lookout.plan.places[view.place], view.eye_m, view.yaw, view.pitch)

    def _next_leg(self, start: Stance, now_s: float) -> Leg:
        """Return the way to what somebody asked for, or to what is worth most for its time."""
        lookout, wanted = self.lookout, self._wanted
        self._wanted = None
        ways = lookout.plan.ways_from(lookout.plan.nearest(start.xy))
        asked = None if wanted is None else lookout.close_to(wanted)
        view = asked or self._most_worth(start, ways, now_s)
        leg = self._leg(start, np.concatenate([start.xy[None], ways.to(view.place)]), view)
        for part in np.linspace(0, 1, CREDITS):
            time_s = float(part) * leg.glide.duration_s
            self._credit(leg.stance(time_s), now_s + time_s)
        return leg

    def _most_worth(self, start: Stance, ways: Ways, now_s: float) -> Viewpoint:
        """Return the viewpoint that shows most that is not fresh, for the time it takes."""
        fresh, views = self._fresh(now_s), self.lookout.viewpoints
        gains = [float(np.maximum(view.scores - fresh, 0.0).sum()) + LEAST_GAIN for view in views]
        costs_s = [
            self._glide(ways.cost_m[view.place], start, view).duration_s + self._pace.dwell_s
            for view in views
        ]
        return views[int(np.argmax(np.divide(gains, costs_s)))]

    def _glide(self, way_m: float, start: Stance, view: Viewpoint) -> Glide:
        climb_m = np.hypot(way_m, view.eye_m - start.eye_m)
        turn = np.hypot(_turn(start.yaw, view.yaw), view.pitch - start.pitch)
        needs = (float(climb_m), self._speed_m_s), (float(turn), self._turn_s)
        return Glide.within(self._pace.ramp_s, *needs)

    def _leg(self, start: Stance, way: Float64, view: Viewpoint) -> Leg:
        steps_m = np.hypot(*np.diff(way, axis=0).T)
        mileage_m = np.concatenate([[0.0], np.cumsum(steps_m)])
        glide = self._glide(float(mileage_m[-1]), start, view)
        look = Glide(max(self._pace.dwell_s, 2 * self._pace.ramp_s), self._pace.ramp_s)
        quickest = 2 * np.pi / (look.duration_s - look.ramp_s)
        pan = min(np.radians(PAN_DEG), self._turn_s / quickest)
        end = self._stance(view)
        turn = _turn(start.yaw, view.yaw)
        return Leg(start, end, way, mileage_m, turn, float(pan), glide, look)

    def _held(self, leg: Leg, time_s: float, now_s: float, walked_m: float) -> Float64:
        stance = leg.stance(time_s)
        speed = leg.glide.speed(time_s) * self._briskness(leg)
        walked_m += leg.walked_m(time_s)
        offset_m, turn = self._tremor.at(now_s, walked_m, speed)
        T_world_camera = stance.pose()
        T_world_camera[:3, 3] += T_world_camera[:3, :3] @ offset_m
        T_world_camera[:3, :3] = T_world_camera[:3, :3] @ _rotation(turn)
        return T_world_camera

    def _briskness(self, leg: Leg) -> float:
        cruise_m_s = float(leg.mileage_m[-1]) / (leg.glide.duration_s - leg.glide.ramp_s)
        return min(cruise_m_s / self._speed_m_s, 1.0)

    def _fresh(self, now_s: float) -> Float64:
        """Return how well (N,) each thing is remembered, 0 to 1."""
        fresh = np.zeros(len(self.lookout.glance.ids))
        for k, thing_id in enumerate(self.lookout.glance.ids.tolist()):
            if thing_id in self._seen:
                score, seen_s = self._seen[thing_id]
                fresh[k] = score * np.exp((seen_s - now_s) / MEMORY_S)
        return fresh

    def _credit(self, stance: Stance, now_s: float) -> None:
        """Remember what is seen from here."""
        scores = self.lookout.scores(self.lookout.glance.at(stance.pose()).pixels)
        for k in np.flatnonzero(scores > self._fresh(now_s)).tolist():
            self._seen[int(self.lookout.glance.ids[k])] = float(scores[k]), now_s


def _turn(a: float, b: float) -> float:
    """Return the shorter way from one direction to another, -pi to pi."""
    return float((b - a + np.pi) % (2 * np.pi) - np.pi)


def _rotation(vector: Float64) -> Float64:
    import cv2

    return np.asarray(cv2.Rodrigues(vector)[0], dtype=np.float64)
