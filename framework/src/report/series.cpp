#include "report/series.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "util/numbers.hpp"

namespace gripline::report {
namespace {

bool any_number(std::span<const double> values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

/// d(values)/dt by central differences, one-sided at the ends; NaN where time does not advance.
std::vector<double> slope(std::span<const double> t, std::span<const double> values) {
  std::vector<double> out(values.size(), not_a_number);
  if (values.size() < 2) return out;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t before = i == 0 ? 0 : i - 1;
    const std::size_t after = std::min(i + 1, values.size() - 1);
    const double dt = t[after] - t[before];
    if (dt > 0) out[i] = (values[after] - values[before]) / dt;
  }
  return out;
}

std::vector<double> copy(std::span<const double> values) { return {values.begin(), values.end()}; }

// Two times `stride` rows become their smallest and their largest value in their order. What remains at the end for one
// place only joins the two before it, and its place takes the last value.
void keep_extremes(std::span<const double> values, std::size_t stride, std::vector<double>& out) {
  const auto less = [](double a, double b) { return std::isnan(b) ? !std::isnan(a) : a < b; };
  const auto more = [](double a, double b) { return std::isnan(b) ? !std::isnan(a) : a > b; };
  const std::size_t n = values.size();
  for (std::size_t begin = 0; begin < n;) {
    std::size_t end = std::min(begin + 2 * stride, n);
    const bool joined = end == begin + 2 * stride && end < n && n - end <= stride;
    if (joined) end = n;
    const auto rows = values.subspan(begin, end - begin);
    const auto low = std::min_element(rows.begin(), rows.end(), less);
    const auto high = std::min_element(rows.begin(), rows.end(), more);
    out.push_back(low < high ? *low : *high);
    if (rows.size() > stride) out.push_back(low < high ? *high : *low);
    if (joined) out.push_back(rows.back());
    begin = end;
  }
}

class TimeSeriesList {
 public:
  explicit TimeSeriesList(const Columns& steps) : steps_(steps) {}

  /// `name` from the first of `columns` that holds numbers.
  void take(std::string name, Thinning thinning, std::initializer_list<const char*> columns) {
    for (const char* column : columns) {
      const std::span<const double> values = steps_.numbers(column);
      if (!any_number(values)) continue;
      channels_.push_back({std::move(name), thinning, copy(values)});
      return;
    }
  }
  void add(std::string name, Thinning thinning, std::vector<double> values) {
    channels_.push_back({std::move(name), thinning, std::move(values)});
  }
  /// Empty if there is no such channel.
  [[nodiscard]] std::span<const double> find(std::string_view name) const {
    for (const TimeSeries& channel : channels_)
      if (channel.name == name) return channel.values;
    return {};
  }
  std::vector<TimeSeries> release() { return std::move(channels_); }

 private:
  const Columns& steps_;
  std::vector<TimeSeries> channels_;
};

// The rates of the velocity in the car's turning axes, plus the turning of the axes: a = dv/dt + w x v.
void add_accelerations(TimeSeriesList& list) {
  const std::span<const double> t = list.find("t"), vx = list.find("vx"), vy = list.find("vy"),
                                w = list.find("yaw_rate");
  if (vx.empty() || vy.empty() || w.empty()) return;
  std::vector<double> ax = slope(t, vx), ay = slope(t, vy);
  for (std::size_t i = 0; i < t.size(); ++i) {
    ax[i] -= vy[i] * w[i];
    ay[i] += vx[i] * w[i];
  }
  list.add("ax", Thinning::extremes, std::move(ax));
  list.add("ay", Thinning::extremes, std::move(ay));
}

/// Both axles' values, weighted by their static loads.
std::vector<double> of_whole_car(std::span<const double> front, std::span<const double> rear, const CarShape& car) {
  const double share = front_share(car);
  std::vector<double> out(front.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = share * front[i] + (1 - share) * rear[i];
  return out;
}

void add_belief(TimeSeriesList& list, const CarShape& car) {
  const std::span<const double> front = list.find("mu_front"), rear = list.find("mu_rear");
  if (front.empty() || rear.empty()) return;
  list.add("mu_belief", Thinning::extremes, of_whole_car(front, rear, car));
}

}  // namespace

double front_share(const CarShape& car) { return car.lf + car.lr > 0 ? car.lr / (car.lf + car.lr) : 0.5; }

std::vector<double> thin(std::span<const double> values, Thinning thinning, std::size_t stride) {
  if (stride <= 1) return copy(values);
  std::vector<double> out;
  if (thinning == Thinning::extremes) {
    keep_extremes(values, stride, out);
    return out;
  }
  for (std::size_t begin = 0; begin < values.size(); begin += stride) {
    const auto rows = values.subspan(begin, std::min(stride, values.size() - begin));
    out.push_back(thinning == Thinning::any ? *std::max_element(rows.begin(), rows.end()) : rows.front());
  }
  return out;
}

std::vector<TimeSeries> step_channels(const Run& run, const CarShape& car) {
  TimeSeriesList list(run.steps);
  using enum Thinning;
  list.take("t", sample, {"t_s"});
  if (list.find("t").empty()) return {};
  list.take("x", sample, {"x_true_m", "x_m"});
  list.take("y", sample, {"y_true_m", "y_m"});
  list.take("yaw", sample, {"yaw_true_rad", "yaw_rad"});
  list.take("s", sample, {"s_m"});
  list.take("lap", sample, {"lap"});
  list.take("vx", extremes, {"vx_true_mps", "vx_mps"});
  list.take("vy", extremes, {"vy_true_mps", "vy_mps"});
  list.take("yaw_rate", extremes, {"yaw_rate_true_radps", "yaw_rate_radps"});
  list.take("d", extremes, {"d_applied", "d"});
  list.take("delta", extremes, {"delta_applied_rad", "delta_rad"});
  list.take("offset", extremes, {"offset_m"});
  list.take("outside", any, {"outside"});
  list.take("v_ref", extremes, {"v_ref_mps"});
  list.take("mu_front", extremes, {"mu_belief_front"});
  list.take("mu_rear", extremes, {"mu_belief_rear"});
  list.take("mu_true", extremes, {"mu_true"});
  list.take("iterations", extremes, {"iterations"});
  list.take("solved", extremes, {"solved"});
  add_belief(list, car);
  add_accelerations(list);
  const std::span<const double> solve = run.timing.numbers("solve_ms");
  if (solve.size() == run.steps.rows() && any_number(solve)) list.add("solve_ms", extremes, copy(solve));
  return list.release();
}

std::vector<double> mu_sigma(const Run& run, const CarShape& car) {
  const std::span<const double> front = run.replay.numbers("mu_sigma_front"),
                                rear = run.replay.numbers("mu_sigma_rear");
  if (front.size() != rear.size() || !any_number(front) || !any_number(rear)) return {};
  return of_whole_car(front, rear, car);
}

}  // namespace gripline::report
