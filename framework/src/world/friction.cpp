#include "world/friction.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "util/numbers.hpp"

namespace gripline {
namespace {

std::string check_points(const std::vector<FrictionSpec::PointInTime>& points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!std::isfinite(points[i].t)) return format("friction point %zu has no finite time", i + 1);
    if (!(points[i].factor > 0.0) || !std::isfinite(points[i].factor)) {
      return format("friction point %zu has factor %g, expected more than 0", i + 1, points[i].factor);
    }
    if (i > 0 && points[i].t < points[i - 1].t) {
      return format("friction goes back in time: point %zu is at %g s, the one before at %g s", i + 1, points[i].t,
                    points[i - 1].t);
    }
  }
  return {};
}

std::string check_per_step(const FrictionSpec::PerStep& per_step) {
  if (!(per_step.divide > 1.0) || !std::isfinite(per_step.divide)) {
    return format("friction per_step divides by %g, expected more than 1", per_step.divide);
  }
  if (per_step.start_step < 0)
    return format("friction per_step starts at step %lld, expected 0 or later",
                  static_cast<long long>(per_step.start_step));
  if (per_step.end_step && *per_step.end_step < per_step.start_step) {
    return format("friction per_step goes back in time: it ends at step %lld before it starts at %lld",
                  static_cast<long long>(*per_step.end_step), static_cast<long long>(per_step.start_step));
  }
  return {};
}

std::string check_patch(const FrictionSpec::Patch& patch, std::size_t number, double track_length) {
  if (!(patch.factor > 0.0) || !std::isfinite(patch.factor)) {
    return format("friction patch %zu has factor %g, expected more than 0", number, patch.factor);
  }
  for (const double s : {patch.from_s, patch.to_s}) {
    if (!(s >= 0.0) || !std::isfinite(s) || (track_length > 0.0 && s > track_length)) {
      return format("friction patch %zu names s = %g m, expected 0 to the track's length %g m", number, s,
                    track_length);
    }
  }
  if (patch.from_s == patch.to_s) return format("friction patch %zu begins and ends at s = %g m", number, patch.from_s);
  if (!std::isfinite(patch.from_t)) return format("friction patch %zu has no finite from_t", number);
  return {};
}

/// A sudden change belongs to the step that begins at its time, whatever rounding makes of either; `near` is what may
/// lie between [s].
double at_time(const std::vector<FrictionSpec::PointInTime>& points, double t, double near) {
  if (points.empty()) return 1.0;
  const auto after = [&](double time) {
    return std::upper_bound(points.begin(), points.end(), time,
                            [](double a, const auto& point) { return a < point.t; });
  };
  const auto next = after(t);
  if (next != points.end() && next->t - t < near)
    if (const auto last = after(next->t); last - next > 1) return (last - 1)->factor;
  if (next == points.begin()) return points.front().factor;
  if (next == points.end()) return points.back().factor;
  const auto& from = *(next - 1);
  return from.factor + (t - from.t) / (next->t - from.t) * (next->factor - from.factor);
}

/// Whether a shift is not a multiple of the control step although steps are counted.
std::string check_shift(const FrictionSpec& spec, double shift, double dt) {
  if (!spec.per_step || std::abs(std::round(shift / dt) * dt - shift) <= 1e-9 * std::max(1.0, std::abs(shift)))
    return {};
  return format("friction shift_per_seed %g s is not a multiple of the control step of %g s", spec.shift_per_seed, dt);
}

}  // namespace

std::string check_shift_per_seed(const FrictionSpec& spec, double dt) {
  return check_shift(spec, spec.shift_per_seed, dt);
}

std::string check_friction(const FrictionSpec& spec, double track_length) {
  if (std::string bad = check_points(spec.points); !bad.empty()) return bad;
  if (spec.per_step) {
    if (std::string bad = check_per_step(*spec.per_step); !bad.empty()) return bad;
  }
  for (std::size_t i = 0; i < spec.patches.size(); ++i) {
    if (std::string bad = check_patch(spec.patches[i], i + 1, track_length); !bad.empty()) return bad;
  }
  if (!std::isfinite(spec.shift_per_seed)) return "friction shift_per_seed is not a finite time";
  return {};
}

FrictionSchedule::FrictionSchedule(FrictionSpec spec, double dt, std::uint64_t seed)
    : spec_(std::move(spec)), near_(1e-6 * dt) {
  if (const std::string bad = check_friction(spec_); !bad.empty()) throw std::invalid_argument(bad);
  const double shift = spec_.shift_per_seed * (static_cast<double>(seed) - 1.0);
  for (auto& point : spec_.points) point.t += shift;
  for (auto& patch : spec_.patches) patch.from_t += shift;
  if (spec_.per_step && shift != 0.0) {
    if (const std::string bad = check_shift(spec_, shift, dt); !bad.empty()) throw std::invalid_argument(bad);
    const double steps = std::round(shift / dt);
    spec_.per_step->start_step += static_cast<std::int64_t>(steps);
    if (spec_.per_step->end_step) *spec_.per_step->end_step += static_cast<std::int64_t>(steps);
  }
}

double FrictionSchedule::base(std::int64_t step, double t) const {
  double factor = at_time(spec_.points, t, near_);
  if (spec_.per_step) {
    const std::int64_t last = std::min(step, spec_.per_step->end_step.value_or(step));
    const std::int64_t times = last - spec_.per_step->start_step + 1;
    // f -= f / divide, `times` times.
    if (times > 0) factor *= std::pow(1.0 - 1.0 / spec_.per_step->divide, static_cast<double>(times));
  }
  return factor;
}

double FrictionSchedule::factor(std::int64_t step, double t, double s) const {
  double factor = base(step, t);
  for (const FrictionSpec::Patch& patch : spec_.patches) {
    if (t < patch.from_t - near_) continue;
    const bool inside =
        patch.from_s < patch.to_s ? s >= patch.from_s && s < patch.to_s : s >= patch.from_s || s < patch.to_s;
    if (inside) factor *= patch.factor;
  }
  return factor;
}

}  // namespace gripline
