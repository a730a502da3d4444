#include "geometry/racing_line.hpp"

#include <algorithm>
#include <array>

#include "geometry/cyclic_box_qp.hpp"
#include "geometry/place_text.hpp"
#include "util/numbers.hpp"

namespace gripline {
namespace {

/// Weights of the cost: the integral of kappa^2 + length_weight [1/m2], and a quadratic penalty on curvature beyond
/// max_curvature [1/m] (0: none).
struct CostWeights {
  double length_weight = 0.0;
  double max_curvature = 0.0;
};

/// The road cut at equal stations: the line's points are base + n * normal.
struct Frame {
  std::vector<PlanePoint> base, normal;
  std::vector<double> lower, upper;
};

Frame cut(const Track& track, const RacingLineOptions& options, std::size_t count) {
  Frame frame;
  const double keep = 0.5 * options.car_width + options.margin;
  const double keep_left = keep + options.margin_left, keep_right = keep + options.margin_right;
  for (std::size_t i = 0; i < count; ++i) {
    const CurvePoint point = track.at(track.length() * static_cast<double>(i) / static_cast<double>(count));
    frame.base.push_back({point.x, point.y});
    frame.normal.push_back({-std::sin(point.yaw), std::cos(point.yaw)});
    frame.lower.push_back(keep_right - track.half_width_right(point.s));
    frame.upper.push_back(track.half_width_left(point.s) - keep_left);
    if (!(frame.lower.back() < frame.upper.back()))
      throw GeometryError(
          format("no racing line: at s = %.4g m the road is %.4g m wide, the car with its margins %.4g m", point.s,
                 track.half_width_right(point.s) + track.half_width_left(point.s), keep_left + keep_right) +
          (options.margin > 0.0
               ? format("; the planner's \"margin\" is %.4g m of that on both sides, less of it may do", options.margin)
               : ""));
  }
  return frame;
}

/// Turn of the polyline at its middle point and the way that belongs to it, with derivatives by the three offsets.
struct Turn {
  double angle = 0.0, way = 0.0;
  std::array<double, 3> angle_by{}, way_by{};
};

Turn turn_at(const Frame& frame, std::span<const double> offsets, std::size_t i) {
  const std::size_t n = offsets.size();
  const std::array<std::size_t, 3> at{i == 0 ? n - 1 : i - 1, i, i + 1 == n ? 0 : i + 1};
  std::array<PlanePoint, 3> p;
  for (int k = 0; k < 3; ++k) {
    const std::size_t j = at[k];
    p[k] = {frame.base[j].x + offsets[j] * frame.normal[j].x, frame.base[j].y + offsets[j] * frame.normal[j].y};
  }
  const double ax = p[1].x - p[0].x, ay = p[1].y - p[0].y, bx = p[2].x - p[1].x, by = p[2].y - p[1].y;
  const double a = std::hypot(ax, ay), b = std::hypot(bx, by);
  Turn turn;
  turn.angle = std::atan2(ax * by - ay * bx, ax * bx + ay * by);
  turn.way = 0.5 * (a + b);
  // A chord (x, y) turns by (x dy - y dx) / |chord|^2 and grows by (x dx + y dy) / |chord|.
  for (int k = 0; k < 3; ++k) {
    const PlanePoint& normal = frame.normal[at[k]];
    const double turn_a = (ax * normal.y - ay * normal.x) / (a * a), turn_b = (bx * normal.y - by * normal.x) / (b * b);
    const double grow_a = (ax * normal.x + ay * normal.y) / a, grow_b = (bx * normal.x + by * normal.y) / b;
    const double in_a = k == 0 ? -1.0 : k == 1 ? 1.0 : 0.0, in_b = k == 1 ? -1.0 : k == 2 ? 1.0 : 0.0;
    turn.angle_by[k] = in_b * turn_b - in_a * turn_a;
    turn.way_by[k] = 0.5 * (in_a * grow_a + in_b * grow_b);
  }
  return turn;
}

constexpr double excess_weight = 100.0;  // of squared curvature beyond the bound, against squared curvature

/// The polyline's cost, its curvature being angle / way.
double cost(const Frame& frame, std::span<const double> offsets, const CostWeights& weights) {
  double sum = 0.0;
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    const Turn turn = turn_at(frame, offsets, i);
    sum += turn.angle * turn.angle / turn.way + weights.length_weight * turn.way;
    const double excess = std::abs(turn.angle) / turn.way - weights.max_curvature;
    if (weights.max_curvature > 0.0 && excess > 0.0) sum += excess_weight * excess * excess * turn.way;
  }
  return sum;
}

/// Gauss-Newton model of half the cost.
struct Model {
  explicit Model(std::size_t n) : hessian(n), gradient(n, 0.0) {}

  /// Adds residual^2 / 2, the residual having these derivatives by the offsets i-1, i, i+1.
  void add(std::size_t i, double residual, const std::array<double, 3>& by) {
    const std::size_t n = gradient.size();
    const std::array<std::size_t, 3> at{i == 0 ? n - 1 : i - 1, i, i + 1 == n ? 0 : i + 1};
    for (int k = 0; k < 3; ++k) {
      gradient[at[k]] += residual * by[k];
      hessian.diagonal[at[k]] += by[k] * by[k];
    }
    hessian.next[at[0]] += by[0] * by[1];
    hessian.next[at[1]] += by[1] * by[2];
    hessian.second[at[0]] += by[0] * by[2];
  }

  CyclicPentadiagonal hessian;
  std::vector<double> gradient;
};

Model linearise(const Frame& frame, std::span<const double> offsets, const CostWeights& weights) {
  const double max_curvature = weights.max_curvature, length_root = std::sqrt(weights.length_weight);
  Model model(offsets.size());
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    const Turn turn = turn_at(frame, offsets, i);
    const double root = std::sqrt(turn.way);
    std::array<double, 3> by{};
    for (int k = 0; k < 3; ++k) by[k] = (turn.angle_by[k] - 0.5 * turn.angle / turn.way * turn.way_by[k]) / root;
    model.add(i, turn.angle / root, by);
    if (length_root > 0.0) {
      std::array<double, 3> longer{};
      for (int k = 0; k < 3; ++k) longer[k] = 0.5 * length_root / root * turn.way_by[k];
      model.add(i, length_root * root, longer);
    }
    const double excess = std::abs(turn.angle) / turn.way - max_curvature;
    if (max_curvature > 0.0 && excess > 0.0) {
      // residual = sqrt(weight) (|angle| / sqrt(way) - max_curvature sqrt(way))
      const double sign = turn.angle > 0.0 ? 1.0 : -1.0, weight = std::sqrt(excess_weight);
      for (int k = 0; k < 3; ++k) by[k] = weight * (sign * by[k] - 0.5 * max_curvature / root * turn.way_by[k]);
      model.add(i, weight * excess * root, by);
    }
  }
  // A shift of the whole line may change no curvature at all: a small regularisation makes the Hessian definite.
  double largest = 0.0;
  for (const double d : model.hessian.diagonal) largest = std::max(largest, d);
  for (double& d : model.hessian.diagonal) d += 1e-13 * largest;
  return model;
}

/// Gauss-Newton steps from `offsets` to a local minimum; each step is a box QP, shortened until the cost falls.
void descend(const Frame& frame, const CostWeights& weights, int most_steps, double settled,
             std::vector<double>& offsets, int& iterations) {
  const std::size_t n = offsets.size();
  std::vector<double> trial(n), lower(n), upper(n);
  double now = cost(frame, offsets, weights);
  for (int k = 0; k < most_steps; ++k) {
    const Model model = linearise(frame, offsets, weights);
    for (std::size_t i = 0; i < n; ++i) {
      lower[i] = frame.lower[i] - offsets[i];
      upper[i] = frame.upper[i] - offsets[i];
    }
    const std::vector<double> step = solve_cyclic_box_qp(model.hessian, model.gradient, lower, upper);
    ++iterations;
    double share = 1.0, next = INFINITY;
    for (int halvings = 0; halvings < 30; ++halvings, share *= 0.5) {
      for (std::size_t i = 0; i < n; ++i) trial[i] = offsets[i] + share * step[i];
      next = cost(frame, trial, weights);
      if (next < now) break;
    }
    if (!(next < now)) return;
    offsets = trial;
    const bool small = now - next < settled * now;
    now = next;
    if (small) return;
  }
}

/// The cost has several local minima: without weight on the length a line may swing wide around hairpins. Continuation
/// finds a good one: the weight starts large and is lowered step by step.
std::vector<double> optimise(const Frame& frame, const RacingLineOptions& options, double mean_squared_curvature,
                             int& iterations) {
  std::vector<double> offsets(frame.base.size());
  for (std::size_t i = 0; i < offsets.size(); ++i) offsets[i] = std::clamp(0.0, frame.lower[i], frame.upper[i]);
  const CostWeights wanted{options.length_weight * mean_squared_curvature, options.max_curvature};
  for (const double share : {3.0, 1.0, 0.3, 0.1}) {
    if (share <= options.length_weight) continue;
    const CostWeights stage{share * mean_squared_curvature, options.max_curvature};
    descend(frame, stage, options.max_iterations, 1e-4, offsets, iterations);
  }
  descend(frame, wanted, options.max_iterations, 1e-10, offsets, iterations);
  return offsets;
}

}  // namespace

RacingLine minimum_curvature_line(const Track& track, const RacingLineOptions& options) {
  double spacing = options.spacing;
  if (!(spacing > 0.0)) {
    constexpr double most_stations = 3000.0;
    spacing = std::max(track.narrowest() / 16.0, track.length() / most_stations);
  }
  const auto count = static_cast<std::size_t>(std::max(32.0, std::round(track.length() / spacing)));
  const Frame frame = cut(track, options, count);
  const double mean_squared = describe_line(track, track.centre(), spacing).squared_curvature / track.length();
  int iterations = 0;
  const std::vector<double> offsets = optimise(frame, options, mean_squared, iterations);
  std::vector<PlanePoint> points(count);
  for (std::size_t i = 0; i < count; ++i) {
    points[i] = {frame.base[i].x + offsets[i] * frame.normal[i].x, frame.base[i].y + offsets[i] * frame.normal[i].y};
  }
  RacingLine line = describe_line(track, ClosedCurve::from_points(points), spacing);
  line.iterations = iterations;
  return line;
}

std::string check_car_turns(const Track& track, double car_width, double least_radius) {
  const auto count = static_cast<int>(std::clamp(track.length() / (0.1 * least_radius), 100.0, 100000.0));
  double sharpest = 0.0;
  for (int i = 0; i < count; ++i) sharpest = std::max(sharpest, std::abs(track.at(track.length() * i / count).kappa));
  if (sharpest * least_radius <= 1.0) return {};
  const RacingLine line = minimum_curvature_line(track, {.car_width = car_width, .max_curvature = 0.98 / least_radius});
  const RacingLineSample* tightest = &line.samples.front();
  for (const RacingLineSample& sample : line.samples)
    if (std::abs(sample.kappa) > std::abs(tightest->kappa)) tightest = &sample;
  const double radius = 1.0 / std::abs(tightest->kappa);
  if (radius >= 0.95 * least_radius) return {};
  return format(
      "a turn is tighter than the car can steer: at s = %.4g m, near %s, the widest line has a "
      "radius of %.3g m, the car's least is %.3g m",
      tightest->centre_s, place_text(tightest->x, tightest->y).c_str(), radius, least_radius);
}

RacingLine describe_line(const Track& track, ClosedCurve curve, double spacing) {
  RacingLine line{std::move(curve), {}, 0.0, 0.0, 0};
  const double length = line.curve.length();
  const auto count = static_cast<std::size_t>(std::max(16.0, std::round(length / spacing)));
  line.samples.resize(count);
  const double step = length / static_cast<double>(count);
  const CurvePoint start = line.curve.at(0.0);
  double hint = track.locate(Pose{start.x, start.y, start.yaw}).s;
  for (std::size_t i = 0; i < count; ++i) {
    const CurvePoint at = line.curve.at(static_cast<double>(i) * step);
    const CurveLocation place = track.locate(at.x, at.y, hint);
    hint = place.s;
    line.samples[i] = {at.s,
                       at.x,
                       at.y,
                       at.yaw,
                       at.kappa,
                       place.s,
                       place.n,
                       track.half_width_left(place.s) - place.n,
                       track.half_width_right(place.s) + place.n};
    line.squared_curvature += at.kappa * at.kappa * step;
    line.largest_curvature = std::max(line.largest_curvature, std::abs(at.kappa));
  }
  return line;
}

}  // namespace gripline
