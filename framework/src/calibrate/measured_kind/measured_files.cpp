// What an experiment of kind "measured" leaves in its folder.
#include <cmath>

#include "calibrate/measured_kind/measured_experiment.hpp"
#include "config/json_file.hpp"
#include "experiment/result_files.hpp"
#include "util/csv_writer.hpp"
#include "util/numbers.hpp"

namespace gripline::calibrate {
namespace {

/// Enough digits for a figure.
Node figure(double value) { return number_or_null(rounded(value, 6)); }

/// A time [s] without the digits that adding leaves.
double microseconds(double time) { return std::round(time * 1e6) / 1e6; }

void write_number(CsvWriter& file, double value) {
  if (std::isfinite(value))
    file << value;
  else
    file << std::string_view();
}

std::string header_of(const char* first, const char* prefix) {
  std::string header = first;
  for (const char* q : quantity_names)
    for (const char* end : {"", "_lo", "_hi"}) header += std::string(",") + prefix + q + end;
  return header;
}

void write_errors(const std::filesystem::path& folder, const MeasuredOutcome& o) {
  CsvWriter file(folder / result_files::errors, header_of("model,starts", ""));
  const auto row = [&](const HorizonRow& r) {
    file << r.name << static_cast<std::int64_t>(r.error[2].count);
    for (const HorizonError& e : r.error)
      for (const double v : {e.rms, e.low, e.high}) write_number(file, v);
    file.end_row();
  };
  for (const HorizonRow& r : o.rows) row(r);
  for (const Ablation& a : o.ablations) row(a.error);
  file.finish();
}

void write_ablation(const std::filesystem::path& folder, const MeasuredOutcome& o) {
  CsvWriter file(folder / result_files::ablation, header_of("effect", "rise_"));
  for (const Ablation& a : o.ablations) {
    file << a.effect;
    for (const HorizonError& e : a.change)
      for (const double v : {e.rms, e.low, e.high}) write_number(file, v);
    file.end_row();
  }
  file.finish();
}

void write_parameters(const std::filesystem::path& folder, const MeasuredOutcome& o) {
  CsvWriter file(folder / result_files::parameters, "pointer,group,value,low,high,prior,learned,status");
  for (const FittedParameter& p : o.fit.parameters) {
    file << p.unknown.pointer << p.unknown.group << p.value << p.interval.low << p.interval.high << p.unknown.prior
         << p.interval.learned << status_names[static_cast<std::size_t>(p.status)];
    file.end_row();
  }
  file.finish();
}

void write_samples(const std::filesystem::path& folder, const MeasuredSpec& spec, const MeasuredOutcome& o) {
  CsvWriter file(folder / result_files::samples,
                 "log,start_s,t_s,x_m,y_m,yaw_rad,vx_mps,vy_mps,yaw_rate_radps,measured_x_m,measured_y_m,"
                 "measured_yaw_rad,measured_vx_mps,measured_vy_mps,measured_yaw_rate_radps");
  for (const HeldOut& h : o.held_out)
    for (std::size_t i = 0; i < h.start.size(); ++i) {
      file << h.log << microseconds(h.begin + h.start[i]) << microseconds(h.begin + h.start[i] + spec.horizon);
      for (std::size_t c = 0; c < channels; ++c) write_number(file, h.predicted[i * channels + c]);
      for (std::size_t c = 0; c < channels; ++c) write_number(file, h.truth[i * channels + c]);
      file.end_row();
    }
  file.finish();
}

Node row_node(const HorizonRow& row) {
  Node node = Node::empty_object();
  node.set("name", Node(row.name));
  for (std::size_t q = 0; q < quantities; ++q) {
    Node values{Node::Array{}};
    for (const double v : {row.error[q].rms, row.error[q].low, row.error[q].high}) values.array().push_back(figure(v));
    node.set(quantity_names[q], std::move(values));
  }
  return node;
}

Node series(const std::vector<double>& values, std::size_t stride = 1, std::size_t first = 0) {
  Node node{Node::Array{}};
  for (std::size_t i = first; i < values.size(); i += stride) node.array().push_back(figure(values[i]));
  return node;
}

Node held_out_node(const HeldOut& h, double horizon) {
  constexpr std::array<const char*, channels> names = {"x_m", "y_m", "yaw_rad", "vx_mps", "vy_mps", "yaw_rate_radps"};
  Node node = Node::empty_object();
  node.set("log", Node(h.log));
  // Not as figures, which of an hour's log tell tens of milliseconds apart.
  Node when{Node::Array{}};
  for (const double t : h.start) when.array().push_back(number_or_null(microseconds(t + horizon)));
  node.set("t_s", std::move(when));
  for (std::size_t c = 0; c < channels; ++c) {
    node.set(std::string("predicted_") + names[c], series(h.predicted, channels, c));
    node.set(std::string("measured_") + names[c], series(h.truth, channels, c));
  }
  return node;
}

Node road_node(const Track& track) {
  constexpr std::size_t points = 600;
  Node road = Node::empty_object();
  std::array<std::vector<double>, 4> edge;  // left x, y; right x, y
  for (std::size_t i = 0; i < points; ++i) {
    const double s = track.length() * static_cast<double>(i) / points;
    const CurvePoint at = track.at(s);
    const double nx = -std::sin(at.yaw), ny = std::cos(at.yaw);
    edge[0].push_back(at.x + nx * track.half_width_left(s));
    edge[1].push_back(at.y + ny * track.half_width_left(s));
    edge[2].push_back(at.x - nx * track.half_width_right(s));
    edge[3].push_back(at.y - ny * track.half_width_right(s));
  }
  for (std::size_t e = 0; e < 4; ++e)
    road.set(std::array{"left_x_m", "left_y_m", "right_x_m", "right_y_m"}[e], series(edge[e]));
  return road;
}

Node parameter_node(const FittedParameter& p) {
  Node node = Node::empty_object();
  node.set("pointer", Node(p.unknown.pointer));
  node.set("group", Node(p.unknown.group));
  for (const auto& [key, value] : {std::pair("value", p.value),
                                   {"low", p.interval.low},
                                   {"high", p.interval.high},
                                   {"prior", p.unknown.prior},
                                   {"learned", p.interval.learned}})
    node.set(key, figure(value));
  node.set("status", Node(status_names[static_cast<std::size_t>(p.status)]));
  return node;
}

Node health_node(const MeasuredOutcome& o) {
  Node all{Node::Array{}};
  for (const auto& [log, findings] : o.health)
    for (const measured::Finding& f : findings) {
      Node line = Node::empty_object();
      line.set("log", Node(log));
      line.set("check", Node(f.check));
      line.set("found", Node(f.found));
      line.set("done", Node(f.done));
      all.array().push_back(std::move(line));
    }
  return all;
}

}  // namespace

void write_measured(const std::filesystem::path& folder, const MeasuredSpec& spec, const MeasuredOutcome& o) {
  write_errors(folder, o);
  write_ablation(folder, o);
  write_parameters(folder, o);
  write_samples(folder, spec, o);
  write_file(folder / result_files::fitted, to_json_text(o.fitted));
  Node page = Node::empty_object();
  page.set("horizon_s", Node(spec.horizon));
  Node rows{Node::Array{}}, ablations{Node::Array{}}, parameters{Node::Array{}}, logs{Node::Array{}},
      advice{Node::Array{}};
  for (const HorizonRow& r : o.rows) rows.array().push_back(row_node(r));
  for (const Ablation& a : o.ablations) {
    HorizonRow change{a.effect, a.change};
    ablations.array().push_back(row_node(change));
  }
  for (const FittedParameter& p : o.fit.parameters) parameters.array().push_back(parameter_node(p));
  for (const HeldOut& h : o.held_out) logs.array().push_back(held_out_node(h, spec.horizon));
  for (const Advice& a : o.fit.advice) {
    Node one = Node::empty_object();
    one.set("effect", Node(a.effect));
    one.set("gain", figure(a.gain));
    one.set("score", figure(a.score));
    advice.array().push_back(std::move(one));
  }
  page.set("rows", std::move(rows));
  page.set("ablations", std::move(ablations));
  page.set("parameters", std::move(parameters));
  page.set("held_out", std::move(logs));
  page.set("advice", std::move(advice));
  page.set("health", health_node(o));
  if (o.road) page.set("road", road_node(*o.road));
  write_file(folder / result_files::measured, to_json_text(page));
}

}  // namespace gripline::calibrate
