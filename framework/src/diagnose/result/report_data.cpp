#include "diagnose/result/report_data.hpp"

#include <algorithm>
#include <cmath>

#include "diagnose/inference/hold_out.hpp"
#include "util/statistics.hpp"

namespace gripline::diagnose {
namespace {

constexpr std::size_t every = 5;      // samples between points of the pictures
constexpr double short_window = 0.2;  // [s]

Node shown_number(double v) {
  // Six digits are more than a picture shows.
  if (!std::isfinite(v)) return Node::null();
  if (v == 0.0) return Node(0.0);
  const double scale = std::pow(10.0, 5.0 - std::floor(std::log10(std::abs(v))));
  return Node(std::round(v * scale) / scale);
}

/// Columns of an object, filled row by row.
class ColumnTable {
 public:
  explicit ColumnTable(std::vector<std::string> names) : names_(std::move(names)), columns_(names_.size()) {}
  void row(std::initializer_list<double> values) {
    std::size_t i = 0;
    for (const double v : values) columns_[i++].push_back(shown_number(v));
  }
  void gap() {
    for (Node::Array& c : columns_) c.push_back(Node::null());
  }
  Node node() && {
    Node out = Node::empty_object();
    for (std::size_t i = 0; i < names_.size(); ++i) out.set(names_[i], Node(std::move(columns_[i])));
    return out;
  }

 private:
  std::vector<std::string> names_;
  std::vector<Node::Array> columns_;
};

Node track_node(const Track& track) {
  ColumnTable t({"x_m", "y_m", "left_x_m", "left_y_m", "right_x_m", "right_y_m"});
  constexpr int points = 600;
  for (int i = 0; i < points; ++i) {
    const double s = track.length() * i / points;
    const CurvePoint p = track.at(s);
    const double nx = -std::sin(p.yaw), ny = std::cos(p.yaw);
    const double left = track.half_width_left(s), right = track.half_width_right(s);
    t.row({p.x, p.y, p.x + left * nx, p.y + left * ny, p.x - right * nx, p.y - right * ny});
  }
  return std::move(t).node();
}

/// Unknown accelerations smoothed from a log under a model: n x 3.
std::vector<double> unexplained(const Catalogue& catalogue, const Problem& problem, const Trace& trace,
                                const ModelSpec& model, const Noise& noise) {
  const LinearModel lm = linearise(catalogue.build(model), trace, problem.stepping());
  FilterOptions options;
  options.smooth = true;
  const Likelihood l = filter(lm, noise, options);
  std::vector<double> a(trace.size() * 3);
  for (std::size_t k = 0; k < trace.size(); ++k)
    for (std::size_t c = 0; c < 3; ++c) a[k * 3 + c] = l.smoothed[(k + 1) * lm.states - 3 + c];
  return a;
}

Node residual_node(const Diagnosis& d, const Diagnoser& diagnoser) {
  const Catalogue& catalogue = diagnoser.catalogue();
  const Problem& problem = diagnoser.problem();
  ColumnTable t({"t_s", "lap_fraction", "x_m", "y_m", "vx_mps", "vy_mps", "yaw_rate_radps", "d", "delta_rad", "e_vx",
                 "e_vy", "e_omega", "after_e_vx", "after_e_vy", "after_e_omega", "size"});
  // Both with the same freedom, so that a smaller curve means a better model.
  Noise noise = d.null_model.noise;
  for (std::size_t c = 0; c < noise_states; ++c)
    noise.process[c] = std::max(noise.process[c], std::pow(problem.process_unit[c], 2));
  const ModelSpec bare = catalogue.null_model();
  for (const Trace& trace : problem.traces) {
    const std::vector<double> before = unexplained(catalogue, problem, trace, bare, noise);
    const std::vector<double> after = unexplained(catalogue, problem, trace, d.fit.model, noise);
    measured::RolloutOptions options = rollout_options(problem, trace, short_window);
    options.first = 0;
    options.every = every;
    const measured::Rollouts rolled = roll_out(catalogue.build(bare), trace, diagnoser.road(), options);
    std::vector<double> size(trace.size(), std::nan(""));
    const std::size_t width = rolled.samples * channels;
    for (std::size_t i = 0; i < rolled.start.size(); ++i)
      size[rolled.start[i]] = squared_errors(rolled, i * width, (i + 1) * width, problem.sensor).rms();
    for (std::size_t k = 0; k < trace.size(); k += every) {
      const double* const x = trace.motion.data() + k * channels;
      const CommandSample<double>& u = trace.log.command[k];
      t.row({trace.at[k].t, trace.at[k].lap_fraction, x[Channel::x], x[Channel::y], x[Channel::vx], x[Channel::vy],
             x[Channel::yaw_rate], u.d, u.delta, before[k * 3], before[k * 3 + 1], before[k * 3 + 2], after[k * 3],
             after[k * 3 + 1], after[k * 3 + 2], size[k]});
    }
    t.gap();
  }
  return std::move(t).node();
}

/// Predictions of one second, one after the other, over data that was not fitted: those of the gap.
Node traces_node(const Diagnosis& d, const Diagnoser& diagnoser) {
  const HoldOut& hold_out = diagnoser.hold_out();
  if (hold_out.empty()) return Node(Node::Array{});
  const measured::Rollouts before = hold_out.predict_in_turn(diagnoser.nominal(d));
  const measured::Rollouts after = hold_out.predict_in_turn(hold_out.refit(d.fit));
  const Trace& trace = hold_out.traces().front();
  constexpr std::size_t windows = 20;
  Node::Array out;
  for (std::size_t c = Channel::vx; c < channels; ++c) {
    ColumnTable t({"t_s", "measured", "before", "after"});
    for (std::size_t i = 0; i < std::min(windows, before.start.size()); ++i) {
      for (std::size_t j = 0; j < before.samples; ++j) {
        const std::size_t k = before.start[i] + j + 1, at = (i * before.samples + j) * channels + c;
        t.row({trace.log.t0 + static_cast<double>(k) * trace.log.dt, trace.log.reading[k * channels + c],
               before.predicted[at], after.predicted[at]});
      }
      t.gap();
    }
    Node one = Node::empty_object();
    one.set("channel", Node(channel_info[c].column));
    Node columns = std::move(t).node();
    for (Member& m : columns.object()) one.set(m.key, std::move(m.value));
    out.push_back(std::move(one));
  }
  return Node(std::move(out));
}

/// The nominal model's parameters that were refitted.
Node calibrated_node(const Diagnosis& d, const Catalogue& catalogue) {
  Node::Array out;
  const std::span<const Nuisance> all = catalogue.nuisances();
  const std::size_t free = d.fit.theta.size();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto refitted = std::ranges::find(d.nominal_fit, all[i].name, &std::pair<std::string, double>::first);
    if (all[i].delay || refitted == d.nominal_fit.end()) continue;
    const double half = i < free ? normal_95 * std::sqrt(std::max(0.0, d.fit.covariance[i * free + i])) : not_a_number;
    Node one = Node::empty_object();
    one.set("param", Node(all[i].name));
    one.set("given", shown_number(all[i].nominal));
    one.set("found", shown_number(refitted->second));
    one.set("ci95", Node(Node::Array{shown_number(refitted->second - half), shown_number(refitted->second + half)}));
    out.push_back(std::move(one));
  }
  return Node(std::move(out));
}

/// What every candidate is, in the words of its plugin.
Node effects_node(const Catalogue& catalogue) {
  Node out = Node::empty_object();
  for (const Candidate& c : catalogue.candidates()) {
    Node params = Node::empty_object();
    for (std::size_t i = 0; i < c.fitted.size(); ++i) {
      Node one = Node::empty_object();
      one.set("words", Node(std::string(c.decl(i).doc)));
      one.set("unit", Node(std::string(c.decl(i).unit)));
      params.set(c.decl(i).name, std::move(one));
    }
    Node effect = Node::empty_object();
    effect.set("words", Node(std::string(c.entry->decl->summary)));
    effect.set("params", std::move(params));
    out.set(c.id, std::move(effect));
  }
  return out;
}

}  // namespace

Node report_data(const Diagnosis& d, const Diagnoser& diagnoser, const std::string& log, const std::string& world,
                 const Node& patch) {
  Node out = Node::empty_object();
  out.set("sentence", Node(d.sentence));
  out.set("log", Node(log));
  out.set("world", Node(world));
  out.set("effects", effects_node(diagnoser.catalogue()));
  out.set("calibrated", calibrated_node(d, diagnoser.catalogue()));
  out.set("track", track_node(diagnoser.road().track()));
  out.set("residual", residual_node(d, diagnoser));
  ColumnTable horizon({"horizon_s", "before", "after"});
  for (const PredictionError& h : d.horizons) horizon.row({h.seconds, h.before, h.after});
  out.set("horizon", std::move(horizon).node());
  out.set("traces", traces_node(d, diagnoser));
  Node::Array limits;
  for (const DetectionLimit& f : d.detection_limits) {
    Node one = Node::empty_object();
    one.set("effect", Node(f.effect));
    one.set("param", Node(f.param));
    one.set("unit", Node(f.unit));
    one.set("size", shown_number(f.size));
    limits.push_back(std::move(one));
  }
  out.set("seen_at", Node(std::move(limits)));
  Node::Array health;
  constexpr std::array<const char*, 3> levels = {"good", "note", "bad"};
  for (const measured::Finding& h : d.health) {
    Node one = Node::empty_object();
    one.set("check", Node(h.check));
    one.set("found", Node(h.found));
    one.set("done", Node(h.done));
    one.set("level", Node(levels[static_cast<std::size_t>(h.level)]));
    health.push_back(std::move(one));
  }
  out.set("health", Node(std::move(health)));
  out.set("patch", patch);
  return out;
}

}  // namespace gripline::diagnose
