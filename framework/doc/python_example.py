"""gripline from Python, in order: framework/doc/python.md. Run from anywhere; results go to ./out."""

import time

import numpy as np

import gripline

# %% A race: two drivers of the shipped first race for two seconds, and its results as arrays.
SHORT = {"/world/duration": 2, "/world/laps": 0, "/claims": []}
result = gripline.compare("first_race", only=["none", "elm"], set=SHORT, out="out/python_race")
table = result.table
assert list(table["stack"]) == ["none", "elm"]
steps = result.run("elm").steps
speed = np.hypot(steps["vx_mps"], steps["vy_mps"])
print(f"elm: {len(speed)} rows, at most {speed.max():.2f} m/s")


# %% A Python class in the same table.
class Drag(gripline.Estimator):
    """drag, by normalised least mean squares"""

    id = "example.drag"
    params = {"rate": gripline.Param(0.05, "1", 0, 2, "step of normalised least mean squares")}
    c = 0.0

    def update(self, sample):
        phi = -sample["x"][3] ** 2
        self.c += self.params["rate"] * (sample["e"][0] - self.c * phi) * phi / (1e-6 + phi * phi)

    def correction(self, points):
        out = np.zeros((len(points), 3))
        out[:, 0] = -self.c * points[:, 0] ** 2
        return out


class Follow(gripline.Controller):
    """steers at a point ahead, holds the speed"""

    id = "example.follow"
    horizon = 12

    def control(self, now, reference):
        x, y, yaw, vx, delta = now["x"][[0, 1, 2, 3, 6]]
        there = reference[-1]
        bearing = np.arctan2(there[1] - y, there[0] - x) - yaw
        wanted = np.clip(1.2 * np.arctan2(np.sin(bearing), np.cos(bearing)), -0.35, 0.35)
        rate = np.clip((wanted - delta) / self.context["dt"], -5, 5)
        return float(np.clip(0.2 + 1.0 * (reference[1, 4] - vx), -0.1, 1.0)), float(rate)


mine = {
    "/stacks/drag": {"estimator": {"plugin": "example.drag", "params": {"rate": 0.1}}, "adapt_after": "0.5 s"},
    "/stacks/follow": {"estimator": None, "planner": {"plugin": "fixed_speed", "params": None},
                       "controller": {"plugin": "example.follow", "params": None}},
}
own = gripline.compare("first_race", only=["none", "drag", "follow"], set={**SHORT, **mine}, plugins=[Drag, Follow],
                       out="out/python_own")
assert list(own.runs["status"]) == ["finished"] * 3, own.runs["status"]
drag, none = own.run("drag").timing, own.run("none").timing
print(f"crossing: update {np.median(drag['update_ms']) * 1e3:.0f} us, "
      f"solve {np.median(drag['solve_ms'][30:]):.2f} ms where {np.median(none['solve_ms'][30:]):.2f} ms without")

# %% Step by step: pure pursuit in Python's own loop.
race = gripline.Race("first_race", set={"/world/laps": 1})
names = race.observation_names
observation, info = race.reset(seed=1)
way = 0.0
for _ in range(400):
    see = dict(zip(names, observation))
    wanted = 0.062 * see["kappa2_1pm"] - 1.5 * see["offset_m"] - 1.0 * see["heading_error_rad"]
    rate = np.clip((np.clip(wanted, -0.35, 0.35) - see["delta_rad"]) / race.dt, race.action_low[1], race.action_high[1])
    observation, reward, terminated, truncated, info = race.step((0.2 + 0.8 * (0.8 - see["vx_mps"]), rate))
    way += reward
    if terminated or truncated:
        break
print(f"{way:.1f} m in {info['t']:.1f} s")
assert way > 4 and not terminated

race.reset()
begin = time.process_time()
count = 0
while count < 20_000:
    *_, terminated, truncated, info = race.step((0.1, 0.0))
    count += 1
    if terminated or truncated:
        race.reset()
rate = count / (time.process_time() - begin)
print(f"{rate:.0f} steps a second of CPU")
assert rate > 20_000
