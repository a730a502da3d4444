#include "limit/starting_line.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/plane.hpp"
#include "geometry/racing_line.hpp"

namespace gripline {
namespace {

/// A line at some stations of the centre line: heading relative to it, curvature, way to the next, speed.
struct Driven {
  std::vector<double> n, xi, kappa, way, v;
};

Driven shape_of(const Track& track, const std::vector<double>& stations, const StartingLine& line) {
  const std::size_t count = stations.size();
  std::vector<PlanePoint> at(count);
  Driven d;
  for (std::size_t k = 0; k < count; ++k) {
    const CurvePoint p = track.at(stations[k]);
    const double n = line.at(stations[k], track.length());
    d.n.push_back(n);
    at[k] = {p.x - n * std::sin(p.yaw), p.y + n * std::cos(p.yaw)};
  }
  const auto next = [&](std::size_t k) { return k + 1 < count ? k + 1 : 0; };
  const auto before = [&](std::size_t k) { return k > 0 ? k - 1 : count - 1; };
  std::vector<double> heading(count);
  for (std::size_t k = 0; k < count; ++k) {
    const PlanePoint &a = at[k], &b = at[next(k)];
    d.way.push_back(std::hypot(b.x - a.x, b.y - a.y));
    heading[k] = std::atan2(b.y - a.y, b.x - a.x);  // of the piece from k to k + 1
  }
  for (std::size_t k = 0; k < count; ++k) {
    const double turned = wrap_angle(heading[k] - heading[before(k)]);
    const double yaw = heading[before(k)] + 0.5 * turned;
    d.xi.push_back(wrap_angle(yaw - track.at(stations[k]).yaw));
    d.kappa.push_back(turned / (0.5 * (d.way[before(k)] + d.way[k])));
  }
  return d;
}

/// Speeds by the friction circle in turns, then a backward and a forward pass with the car's brakes and drive.
void set_speeds(Driven& d, const LapCar& plant) {
  constexpr double careful = 0.6;  // share of the friction that is used
  const std::size_t count = d.n.size();
  const Car& car = plant.car();
  const double side = careful * plant.mu() * gravity;
  double top = car.v_ref;
  while (top < 10.0 * car.v_ref && plant.acceleration(top, car.d_max) > 0.0) top *= 1.1;
  for (std::size_t k = 0; k < count; ++k)
    d.v.push_back(std::clamp(std::sqrt(side / std::max(std::abs(d.kappa[k]), 1e-6)), 0.2 * car.v_ref, 0.9 * top));
  for (int round = 0; round < 2; ++round) {
    for (std::size_t i = count; i-- > 0;) {
      const std::size_t next = i + 1 < count ? i + 1 : 0;
      const double slow = std::max(0.0, -plant.acceleration(d.v[next], car.d_min));
      d.v[i] = std::min(d.v[i], std::sqrt(d.v[next] * d.v[next] + 2.0 * careful * slow * d.way[i]));
    }
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t next = i + 1 < count ? i + 1 : 0;
      const double gain = std::max(0.0, plant.acceleration(d.v[i], car.d_max));
      d.v[next] = std::min(d.v[next], std::sqrt(d.v[i] * d.v[i] + 2.0 * gain * d.way[i]));
    }
  }
}

Driven drive(const Track& track, const std::vector<double>& stations, const StartingLine& line, const LapCar& plant) {
  Driven d = shape_of(track, stations, line);
  set_speeds(d, plant);
  return d;
}

}  // namespace

double StartingLine::at(double station, double length) const {
  if (s.empty()) return 0.0;
  const auto above = std::upper_bound(s.begin(), s.end(), station);
  const auto i = static_cast<std::size_t>(above - s.begin());
  const std::size_t hi = i < s.size() ? i : 0, lo = i > 0 ? i - 1 : s.size() - 1;
  const double from = i > 0 ? s[lo] : s[lo] - length, to = i < s.size() ? s[hi] : s[hi] + length;
  return to > from ? n[lo] + (n[hi] - n[lo]) * (station - from) / (to - from) : n[lo];
}

std::vector<StartingLine> starting_lines(const Track& track, const Car& car) {
  std::vector<StartingLine> lines;
  for (const auto& [name, weight] : {std::pair{"least curvature", 0.0}, {"shorter", 0.3}, {"short", 3.0}}) {
    RacingLineOptions options;
    options.car_width = 1.1 * car.width;
    options.length_weight = weight;
    const RacingLine line = minimum_curvature_line(track, options);
    std::vector<std::pair<double, double>> places;
    for (const RacingLineSample& sample : line.samples) places.emplace_back(sample.centre_s, sample.n);
    std::sort(places.begin(), places.end());
    StartingLine one{name, {}, {}};
    for (const auto& [s, n] : places) {
      if (!one.s.empty() && s - one.s.back() < 1e-9) continue;
      one.s.push_back(s);
      one.n.push_back(n);
    }
    lines.push_back(std::move(one));
  }
  lines.push_back({"centre", {}, {}});
  return lines;
}

std::vector<double> stations_on(const Track& track, const StartingLine& line, const LapCar& plant, std::size_t count) {
  const std::size_t fine = 8 * count;
  std::vector<double> even(fine);
  for (std::size_t i = 0; i < fine; ++i) even[i] = track.length() * static_cast<double>(i) / static_cast<double>(fine);
  const Driven d = drive(track, even, line, plant);
  double time = 0;
  for (std::size_t i = 0; i < fine; ++i) time += d.way[i] / d.v[i];
  std::vector<double> covered(fine + 1, 0.0);
  for (std::size_t i = 0; i < fine; ++i)
    covered[i + 1] = covered[i] + 0.5 / static_cast<double>(fine) + 0.5 * d.way[i] / d.v[i] / time;
  std::vector<double> stations(count);
  std::size_t i = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const double share = covered[fine] * static_cast<double>(k) / static_cast<double>(count);
    while (covered[i + 1] <= share) ++i;
    const double part = (share - covered[i]) / (covered[i + 1] - covered[i]);
    stations[k] = track.length() * (static_cast<double>(i) + part) / static_cast<double>(fine);
  }
  return stations;
}

Lap drive_along(const Track& track, const LapMesh& mesh, const StartingLine& line, const LapCar& plant) {
  const Driven d = drive(track, mesh.s, line, plant);
  const Car& car = plant.car();
  Lap lap;
  for (std::size_t k = 0; k < mesh.size(); ++k) {
    const double delta = std::clamp((car.lf + car.lr) * d.kappa[k], -0.8 * car.delta_max, 0.8 * car.delta_max);
    const double beta = car.lr * d.kappa[k];
    const double v = 0.9 * d.v[k];
    lap.z.push_back({std::clamp(d.n[k], 0.95 * mesh.n_lo[k], 0.95 * mesh.n_hi[k]), std::clamp(d.xi[k], -1.2, 1.2), v,
                     0.1 * beta * v, v * d.kappa[k], delta, 0.2 * car.d_max, 0.0});
  }
  return lap;
}

}  // namespace gripline
