#include "calibrate/fit/session_adaptation.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "calibrate/forecast/horizon_table.hpp"

namespace gripline::calibrate {
namespace {

using Index = Eigen::Index;

constexpr double chunk = 2.0;             // [s] of a log that is predicted by the same parameters
constexpr double between_starts = 0.5;    // [s] between the starts that are judged
constexpr double judged_ahead = 1.0;      // [s] of the predictions that are judged
constexpr double settling_time = 0.3;     // [s] after which no row to come changes a reading
constexpr double forgetting_time = 60.0;  // [s] in which what was learned falls to 1 / e
constexpr double largest_move = 2.5;      // widths
constexpr double slow_share = 0.25;       // of v_ref: slower starts are judged only before the first that is not

class Adaptation {
 public:
  Adaptation(const Forecaster& forecaster, const FitLog& log, std::span<const double> params,
             std::span<const Unknown> moving, const SessionWeighing& weighing)
      : base_(params.begin(), params.end()),
        now_(base_),
        moving_(moving.begin(), moving.end()),
        driven_(judged_starts(forecaster, log,
                              std::max(forecaster.options().v_min, slow_share * forecaster.options().v_ref))),
        crawled_(judged_starts(forecaster, log, forecaster.options().v_min)),
        past_{emptied(log, {judged_ahead})},
        errors_(forecaster, past_),
        information_(Eigen::MatrixXd::Zero(size(), size())),
        pull_(Eigen::VectorXd::Zero(size())) {
    errors_.weighing.scale = weighing.scale;
    errors_.weighing.horizon = {1.0};
    // Errors of a start near a spin are large and their slopes hold nowhere else: unbounded, they would outweigh a
    // minute of others.
    errors_.weighing.steep = errors_.weighing.huber_delta;
    past_.front().weight = weighing.weight;
    for (Unknown& u : moving_) u.sigma = u.session;
  }

  const std::vector<double>& params() const { return now_; }

  /// Takes in all starts whose outcome was known at `time`, and moves the parameters.
  void learn(double time) {
    const double keep = std::exp(-chunk / forgetting_time);
    information_ *= keep;
    pull_ *= keep;
    const bool drives = take(driven_, time);
    if (drives && !has_driven_) {  // what a crawl has said is of static friction and play too
      has_driven_ = true;
      information_.setZero();
      pull_.setZero();
    }
    if (!has_driven_) take(crawled_, time);
    const FitLog& past = past_.front();
    if (!past.starts.time.empty()) {
      const BlockedNormalEquations found = errors_.linearise(now_, moving_);
      const Eigen::VectorXd at = offset();
      for (std::size_t b = 0; b < found.hessian.size(); ++b) {
        information_ += found.hessian[b];
        pull_ += found.hessian[b] * at - found.gradient[b];
      }
    }
    move();
  }

 private:
  /// Starts that are judged, in their order, and the next of them.
  struct Judged {
    FitLog log;
    std::size_t next = 0;
  };

  Index size() const { return static_cast<Index>(moving_.size()); }

  static Judged judged_starts(const Forecaster& forecaster, const FitLog& log, double slowest) {
    return {FitLog(*log.session, forecaster.options().step, {judged_ahead}, between_starts, slowest)};
  }
  /// Puts those whose outcome has become known into `past_`; whether there are any.
  bool take(Judged& judged, double time) {
    FitLog& past = past_.front();
    past.starts.time.clear();
    past.truth.clear();
    const std::vector<double>& starts = judged.log.starts.time;
    for (; judged.next < starts.size() && starts[judged.next] + judged_ahead + settling_time < time; ++judged.next) {
      past.starts.time.push_back(starts[judged.next]);
      const auto* const truth = judged.log.truth.data() + judged.next * channels;
      past.truth.insert(past.truth.end(), truth, truth + channels);
    }
    return !past.starts.time.empty();
  }
  static FitLog emptied(FitLog log, std::vector<double> horizons) {
    log.starts = {{}, std::move(horizons)};
    log.truth.clear();
    return log;
  }

  Eigen::VectorXd offset() const {
    Eigen::VectorXd at(size());
    for (std::size_t i = 0; i < moving_.size(); ++i) {
      const Unknown& u = moving_[i];
      at(static_cast<Index>(i)) = search_value(u, now_[u.index]) - search_value(u, base_[u.index]);
    }
    return at;
  }

  void move() {
    Eigen::MatrixXd all = information_;
    for (std::size_t i = 0; i < moving_.size(); ++i)
      all(static_cast<Index>(i), static_cast<Index>(i)) += 1.0 / (moving_[i].session * moving_[i].session);
    const Eigen::VectorXd to = all.ldlt().solve(pull_);
    if (!to.allFinite()) return;
    for (std::size_t i = 0; i < moving_.size(); ++i) {
      const Unknown& u = moving_[i];
      const double by = std::clamp(to(static_cast<Index>(i)), -largest_move * u.session, largest_move * u.session);
      const double value = u.log ? base_[u.index] * std::exp(by) : base_[u.index] + by;
      assign(now_, u, std::clamp(value, u.low, u.high));
    }
  }

  std::vector<double> base_, now_;
  std::vector<Unknown> moving_;  // with the session's width as their standard deviation
  Judged driven_, crawled_;
  bool has_driven_ = false;
  std::vector<FitLog> past_;  // one: the starts that are new
  PredictionErrors errors_;
  Eigen::MatrixXd information_;
  Eigen::VectorXd pull_;
};

}  // namespace

SessionWeighing session_weighing(const std::array<double, quantities>& rms) {
  const auto scale = [&](std::size_t q) { return rms[q] > 0.0 && std::isfinite(rms[q]) ? rms[q] : 1.0; };
  const double place = scale(0) / std::sqrt(2.0);
  SessionWeighing weighing;
  weighing.scale = {place, place, scale(1), scale(2), scale(3), scale(4)};
  return weighing;
}

std::optional<SessionWeighing> session_weighing(const Node& world) {
  const Node* const row = find_pointer(world, "/calibration/errors_at_horizon/fitted");
  if (row == nullptr) return std::nullopt;
  std::array<double, quantities> rms{};
  for (std::size_t q = 0; q < quantities; ++q) {
    const Node* const figures = row->find(quantity_names[q]);
    if (figures != nullptr && figures->is_array() && !figures->array().empty() && figures->array().front().is_number())
      rms[q] = figures->array().front().number();
  }
  return session_weighing(rms);
}

std::vector<Unknown> session_unknowns(std::span<const Unknown> unknowns) {
  std::vector<Unknown> moving;
  for (const Unknown& u : unknowns)
    if (u.session > 0.0) moving.push_back(u);
  return moving;
}

std::vector<double> predict_session(const Forecaster& forecaster, const FitLog& log, std::span<const double> params,
                                    std::span<const Unknown> moving, const SessionWeighing& weighing,
                                    std::vector<double>* adapted) {
  const std::size_t per_start = log.starts.horizons.size() * channels;
  std::optional<measured::Road> road;
  if (log.track) road.emplace(log.track);
  std::vector<double> all, part;
  if (moving.empty()) {
    forecaster.run<double>(*log.session, log.commands, road ? &*road : nullptr, params, log.starts, all);
    return all;
  }
  Adaptation adaptation(forecaster, log, params, moving, weighing);
  const double begin = log.session->t.front(), end = log.session->t.back();
  std::size_t next = 0;
  double time = begin;
  while (time <= end) {
    adaptation.learn(time);
    time += chunk;
    Starts starts{{}, log.starts.horizons};
    for (; next < log.starts.time.size() && log.starts.time[next] < time; ++next)
      starts.time.push_back(log.starts.time[next]);
    if (starts.time.empty()) continue;
    forecaster.run<double>(*log.session, log.commands, road ? &*road : nullptr, adaptation.params(), starts, part);
    all.insert(all.end(), part.begin(), part.end());
  }
  all.resize(log.starts.time.size() * per_start, std::nan(""));
  if (adapted != nullptr) *adapted = adaptation.params();
  return all;
}

}  // namespace gripline::calibrate
