"""A race step by step, with the calls of Gymnasium's environments."""

import numpy as np

from . import _gripline
from .plugins import offer
from .words import assignments, several

try:  # an environment for those who have it; nothing here needs it
    import gymnasium as _gymnasium

    _Base = _gymnasium.Env
except ImportError:
    _gymnasium = None
    _Base = object


class Race(_Base):
    """The world of an experiment, driven by actions (throttle, steering rate), one per control step.

    Observations are arrays of the numbers in `observation_names`; the reward is the way made good along the centre line
    [m]. An episode is terminated when the car leaves the road or hits a wall, truncated when a race would end (laps,
    duration, timeout, or a car that has stood for 5 s); a car that left the road may be driven on, one that hit a wall
    not. With a `stack` its estimator learns from every step: `info["mu"]` is what it believes.
    """

    metadata = {"render_modes": []}

    def __init__(self, experiment, stack=None, *, seed=1, set=None, plugins=(), plugin_folders=()):
        offer(plugins)
        self._race = _gripline.Race(str(experiment), stack or "", assignments(set), several(plugin_folders))
        self._seed = seed - 1
        self.observation_names = self._race.observation_names
        low, high = self._race.limits
        self.action_low, self.action_high, self.dt = np.array(low), np.array(high), self._race.dt
        if _gymnasium is not None:
            self.action_space = _gymnasium.spaces.Box(self.action_low, self.action_high, dtype=np.float64)
            self.observation_space = _gymnasium.spaces.Box(-np.inf, np.inf, (len(self.observation_names),), np.float64)

    def reset(self, *, seed=None, options=None):
        """Puts the car at its start; returns (observation, info). Without a seed the next one is taken: 1, 2, 3, ..."""
        if _gymnasium is not None:
            super().reset(seed=seed)
        if seed is not None and not (hasattr(seed, "__index__") and 0 <= seed < 2**64):
            raise ValueError(f"a seed is a whole number from 0 on; found {seed!r:.80}")
        self._seed = self._seed + 1 if seed is None else int(seed)
        return self._race.reset(self._seed), {"seed": self._seed}

    def step(self, action):
        """One control step: (observation, reward, terminated, truncated, info)."""
        try:
            throttle, steering_rate = map(float, action)
        except (TypeError, ValueError):
            raise ValueError(f"an action is two numbers, throttle and steering rate; found {action!r:.80}") from None
        return self._race.step(throttle, steering_rate)

    def close(self):
        """Nothing is open."""

    @property
    def state(self):
        """The true state: x, y, yaw, vx, vy, omega, delta."""
        return self._race.state
