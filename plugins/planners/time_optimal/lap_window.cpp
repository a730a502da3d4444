#include "planners/time_optimal/lap_window.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gripline::time_optimal {
namespace {

constexpr double behind = 0.4;            // [s] of window behind the car
constexpr double hold = 0.1;              // [s] that the car goes on before the window follows
constexpr std::size_t fewest_nodes = 30;  // of a window, however fast they are passed

/// A car's position and heading as seen from a point of the base line.
struct Beside {
  double along, left;  // [m]
  double askew;        // [rad]
};
Beside seen_from(const LinePoint& p, const State& car) {
  const double sine = std::sin(p.yaw), cosine = std::cos(p.yaw), dx = car.x - p.x, dy = car.y - p.y;
  return {cosine * dx + sine * dy, cosine * dy - sine * dx, std::remainder(car.yaw - p.yaw, 2.0 * std::numbers::pi)};
}

}  // namespace

LapWindow::LapWindow(const LapSetup& setup, std::size_t most, double ahead)
    : setup_(&setup), most_(most), ahead_(ahead) {}

/// About what the interval that begins at a node takes [s].
double LapWindow::rough_time_over(std::size_t node, const Nodes& lap) const {
  return setup_->nodes().ds[node] / std::max(lap[node].z[lap_vx], least_speed_share * setup_->top_speed());
}

std::size_t LapWindow::length_from(std::size_t first, const Nodes& lap) const {
  double time = 0;
  std::size_t n = 0;
  while (n < most_ && (time < ahead_ + behind || n < fewest_nodes))
    time += rough_time_over((first + n++) % size(), lap);
  return n;
}

std::size_t LapWindow::first_behind(double station, const Nodes& lap) const {
  std::size_t first = setup_->node_at(station);
  double back = 0;
  for (std::size_t i = 0; i < just_behind() && back < behind; ++i) {
    first = setup_->before(first);
    back += rough_time_over(first, lap);
  }
  return first;
}

bool LapWindow::may_stay(std::size_t wanted, const Nodes& lap) const {
  if (count_ == 0) return false;
  double time = 0;
  for (std::size_t k = 0; node(k) != wanted; ++k) {
    if (time > hold || k > size() / 2) return false;
    time += rough_time_over(node(k), lap);
  }
  return time < hold;
}

std::size_t LapWindow::place(std::size_t first, const Nodes& lap) {
  const std::size_t known = reaches(first) ? (last() + size() - first) % size() : 0;
  first_ = first;
  count_ = length_from(first, lap);
  return known;
}

std::size_t node_behind(const LapSetup& setup, const State& car, double station) {
  const LinePoint line = setup.base().at(station);
  const Beside beside = seen_from(line, car);
  return setup.node_at(station + beside.along / std::max(0.2, 1.0 - beside.left * line.kappa));
}

std::array<double, lap_variables> passed_with(const LapSetup& setup, const State& car, std::size_t node) {
  constexpr double steepest = 1.0;  // [rad]
  const Beside beside = seen_from(setup.base_at(node), car);
  const double turned = beside.along * car.omega / std::max(std::hypot(car.vx, car.vy), setup.car().v_min);
  const double course = std::clamp(beside.askew + std::atan2(car.vy, car.vx) - 0.5 * turned, -steepest, steepest);
  std::array<double, lap_variables> z{};
  z[lap_n] = beside.left - beside.along * std::tan(course);
  z[lap_xi] = beside.askew - turned;
  z[lap_vx] = car.vx;
  z[lap_vy] = car.vy;
  z[lap_omega] = car.omega;
  z[lap_delta] = car.delta;
  return z;
}

}  // namespace gripline::time_optimal
