#include "gripline/diagnose_real.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>

#include "calibrate/effect_trial.hpp"
#include "calibrate/handling.hpp"
#include "calibrate/missing_effects.hpp"
#include "config/json_file.hpp"
#include "diagnose/inference/channel_delays.hpp"
#include "diagnose/result/diagnosis_files.hpp"
#include "experiment/out_folder.hpp"
#include "gripline/command.hpp"
#include "measured/gripline_log.hpp"
#include "measured/session_health.hpp"
#include "measured/steady_turning.hpp"
#include "util/csv_writer.hpp"
#include "util/numbers.hpp"
#include "util/progress.hpp"
#include "util/signals.hpp"

namespace gripline::tools {
namespace fs = std::filesystem;
namespace {

using calibrate::MissingEffects;
using diagnose::Diagnosis;
using measured::Source;

bool same_rows(const measured::Session& a, const measured::Session& b) {
  const auto same = [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  return a.t == b.t && std::ranges::equal(a.reading, b.reading, same) &&
         std::ranges::equal(a.command, b.command, [](const CommandSample<double>& x, const CommandSample<double>& y) {
           return x.d == y.d && x.delta == y.delta;
         });
}

/// A log that is given twice is used once; one that is fitted is no judge of the fit.
void check_distinct(std::list<measured::SessionFile>& files, std::list<measured::SessionFile>& held_out) {
  const auto once = [](std::list<measured::SessionFile>& all) {
    for (auto one = all.begin(); one != all.end(); ++one)
      for (auto other = std::next(one); other != all.end();) {
        if (!same_rows(one->session, other->session)) {
          ++other;
          continue;
        }
        std::cerr << other->session.name << ": holds the same rows as " << one->session.name << ", used once\n";
        other = all.erase(other);
      }
  };
  once(files);
  once(held_out);
  for (const measured::SessionFile& held : held_out)
    for (const measured::SessionFile& file : files)
      if (same_rows(held.session, file.session))
        throw InputError("--held-out " + held.session.name + " holds the same rows as the log " + file.session.name +
                         " that is fitted; expected a log that is not");
}

std::list<measured::SessionFile> read_sessions(const std::vector<std::string>& files, const measured::LogMap& map,
                                               double v_ref) {
  std::list<measured::SessionFile> all;
  for (const std::string& file : files) {
    all.push_back(measured::read_session(file, map));
    measured::check_session(all.back(), v_ref);
  }
  return all;
}

/// Whether all that gripline's own columns must have is there, to see delays by; a lateral speed may be absent.
bool has_own_columns(const measured::SessionFile& file) {
  return file.has_throttle &&
         std::ranges::all_of(std::array{Source::x, Source::y, Source::yaw, Source::vx, Source::yaw_rate},
                             [&](Source s) { return file.session.has[static_cast<std::size_t>(s)]; });
}

/// Delays of channels against each other, of the logs on their even grid. `map` leaves in what it says to find.
std::vector<diagnose::ChannelDelay> channel_delays(const std::list<measured::SessionFile>& files, measured::LogMap map,
                                                   const WorldSpec& world, const fs::path& out) {
  for (auto& channel : map.channel)
    if (channel && !channel->delay) channel->delay = 0.0;
  std::vector<measured::LogFile> logs;
  for (const measured::SessionFile& file : files) {
    if (!has_own_columns(file)) return {};
    std::string name = fs::path(file.session.name).stem().string();
    if (!logs.empty()) name += '.' + std::to_string(logs.size() + 1);  // logs of several folders may share a name
    const fs::path written = out / (name + ".gripline.csv");
    for (const std::string& remark : measured::write_gripline_log(written, file, map))
      std::cout << "log: " << file.session.name << ": " << remark << '\n';
    logs.push_back(measured::read_log_file(written, {world.car.car.v_ref, nullptr, world.car.car.delta_max}));
  }
  return diagnose::find_channel_delays(logs);
}

diagnose::ErrorChange change_of(const calibrate::ForecastChange& c) { return {c.change, c.low, c.high}; }

std::string percent(double share) {
  const double value = 100.0 * share;
  return significant(value, std::abs(value) < 99.5 ? 2 : 3) + " %";
}

/// By how much an error became smaller, with its interval.
std::string decrease_text(const calibrate::ForecastChange& c) {
  return percent(-c.change) + " (" + percent(-c.high) + " to " + percent(-c.low) + ")";
}

std::string rest_text(const calibrate::Remainder& rest) {
  if (rest.share <= 0.0) return {};
  std::string text = percent(rest.share);
  text += rest.most ? " of it lies in the third of the time with the largest "
                    : " of it lies in the third with the smallest ";
  if (rest.of == "time") return text.substr(0, text.rfind(" with")) + (rest.most ? " at the end" : " at the beginning");
  text += rest.of == "steering" ? "steering to the left" : rest.of;
  text += rest.most ? " (from " : " (up to ";
  text += significant(rest.from, 3);
  text += rest.of == "speed" ? " m/s" : rest.of == "yaw rate" ? " rad/s" : rest.of == "steering" ? " rad" : "";
  return text + ")";
}

/// How the car answers its steering, beside what the world given says of it.
struct Cornering {
  std::optional<measured::SteadyTurning> by_log;
  std::optional<double> given, found;  // gradients of the models [rad s2/m]
};

Cornering cornering_of(const std::list<measured::SessionFile>& files, const WorldSpec& given,
                       const MissingEffects& found) {
  const Car& car = given.car.car;
  PluginContext context;
  context.car = car;
  const Vehicle as_given(given.vehicle, context), as_found(found.spec.vehicle, context);
  const calibrate::Forecaster forecaster(as_found.car(), calibrate::forecast_options(found.spec));
  std::vector<const measured::Session*> sessions;
  for (const measured::SessionFile& file : files) sessions.push_back(&file.session);
  const auto late = calibrate::turning_lateness(forecaster, found.params, found.parameters);
  Cornering out{measured::steady_turning(sessions, car.lf + car.lr, car.v_ref, late), {}, {}};
  if (!out.by_log) return out;
  out.given = calibrate::gradient_in(*out.by_log, as_given.car(), as_given.car().params());
  out.found = calibrate::gradient_in(*out.by_log, as_found.car(), found.params);
  return out;
}

/// What effects do to the calibrated world's predictions.
std::string real_sentence(const Diagnosis& d, const MissingEffects& found, const Cornering& corners) {
  std::string text;
  for (const diagnose::NamedEffect& one : d.delays) {
    const auto& t = one.params.front();
    text += one.effect == "yaw_rate_delay" ? "The yaw-rate channel is " : "The speed channels are ";
    text += significant(std::abs(t.value), 3) + (t.value > 0.0 ? " s late (" : " s early (");
    text += significant(std::min(std::abs(t.low), std::abs(t.high)), 3) + " to ";
    text += significant(std::max(std::abs(t.low), std::abs(t.high)), 3) + "). ";
  }
  text += found.calibrated < found.given
              ? "Calibrating the world takes " + decrease_text(found.calibration) + " off the error of "
              : "Calibrating the world takes nothing off the error of ";
  text += "predictions 1 s ahead of time that was not fitted";
  if (!found.named.empty()) {
    text += "; ";
    for (std::size_t i = 0; i < d.named.size(); ++i) {
      text += i == 0 ? "" : i + 1 == d.named.size() ? " and " : ", ";
      text += d.named[i].effect + " (";
      for (std::size_t p = 0; p < found.named[i].params.size(); ++p)
        text += (p == 0 ? "" : ", ") + found.named[i].params[p].text(3, false);
      text += ")";
    }
    text += d.named.size() == 1 ? " takes " : " take ";
    text += decrease_text(found.change) + " off what is left then";
  }
  text += ". ";
  if (corners.by_log) text += calibrate::corners_text(*corners.by_log, corners.given) + " ";
  if (found.at_noise())
    return text + "What remains, " + significant(found.found, 3) +
           " usual errors, is as large as the sensors' own noise (" + significant(found.noise, 3) +
           "): nothing more can be told from these logs.";
  text += "What remains, " + significant(found.found, 3) + " usual errors where sensors alone would leave ";
  text += significant(std::min(found.noise, found.found), 2) + ", is not known: ";
  text += found.named.empty() ? "no effect" : "no other effect";
  text += " that was tried takes enough of it off, or surely enough, to be named";
  const std::string rest = rest_text(found.remainder);
  return text + (rest.empty() ? "." : "; " + rest + ".");
}

/// How much of the error beyond what sensors leave is closed, calibration and effects together.
diagnose::Gap gap_of(const MissingEffects& found) {
  const auto closed = [&](double after) {
    return after < found.given ? (found.given - after) / (found.given - std::min(found.noise, after)) : 0.0;
  };
  return {1.0,
          found.given,
          found.found,
          closed(found.found),
          closed(found.given * (1.0 + found.all.high)),
          closed(found.given * (1.0 + found.all.low))};
}

Diagnosis diagnosis_of(const MissingEffects& found, std::span<const diagnose::ChannelDelay> delays,
                       const Cornering& corners) {
  Diagnosis d;
  d.verdict = diagnose::Verdict::unknown;
  for (const diagnose::ChannelDelay& one : delays) {
    diagnose::NamedEffect& delay = d.delays.emplace_back();
    delay.effect = one.name() + "_delay";
    delay.measurement = true;
    delay.params = {{"T", "s", one.seconds, one.low, one.high}};
    delay.confidence = diagnose::thresholds::most_confidence;
  }
  for (const calibrate::MissingEffect& one : found.named) {
    diagnose::NamedEffect& named = d.named.emplace_back();
    named.effect = one.effect;
    named.measurement = one.measurement;
    for (const auto& v : one.params) named.params.push_back({v.name, v.unit, v.value, v.low, v.high, v.at_end()});
    named.confidence = std::min(one.change.certainty, diagnose::thresholds::most_beside_unknown);
    named.rollout = change_of(one.change);
  }
  for (const calibrate::RankedEffect& one : found.ranking)
    d.ranking.push_back({one.effect, one.gain, one.tried ? one.error : NAN, one.tried ? one.change.certainty : 0.0,
                         change_of(one.change)});
  const std::string model = "/plant/params/";
  for (const calibrate::FittedParameter& p : found.parameters)
    if (p.unknown.pointer.starts_with(model))
      d.nominal_fit.emplace_back(p.unknown.pointer.substr(model.size()), p.value);
  d.gap = gap_of(found);
  using diagnose::Where;
  const std::string& of = found.remainder.of;
  d.unknown.emplace();
  d.unknown->where = of == "time" ? Where::time : of == "throttle" || of == "steering" ? Where::input : Where::state;
  d.unknown->quantity = of;
  d.sentence = real_sentence(d, found, corners);
  return d;
}

/// Whether something was found: named, and the error smaller with it, or nothing left beside noise.
bool is_answer(const Diagnosis& d, const MissingEffects& found) {
  const bool named = !d.named.empty() || !d.delays.empty();
  return found.at_noise() || (named && d.gap.closure > 0.0);
}

Node change_node(const calibrate::ForecastChange& c) {
  Node out = Node::empty_object();
  out.set("change", number_or_null(c.change));
  out.set("ci95", Node(Node::Array{number_or_null(c.low), number_or_null(c.high)}));
  return out;
}

/// The understeer gradient by the logs, and of the worlds.
Node understeer_node(const Cornering& corners) {
  if (!corners.by_log) return Node::null();
  const auto of = [](const std::optional<double>& gradient) { return number_or_null(gradient.value_or(NAN)); };
  Node out = Node::empty_object();
  out.set("gradient", number_or_null(corners.by_log->gradient));
  out.set("ci95", Node(Node::Array{number_or_null(corners.by_log->low), number_or_null(corners.by_log->high)}));
  out.set("unit", Node("rad s2/m"));
  out.set("given", of(corners.given));
  out.set("found", of(corners.found));
  return out;
}

/// What effects do to each log that figures are of.
Node sessions_node(std::span<const calibrate::SessionChange> sessions) {
  Node::Array out;
  for (const calibrate::SessionChange& one : sessions) {
    Node row = Node::empty_object();
    row.set("log", Node(fs::path(one.log).filename().string()));
    row.set("calibrated", number_or_null(one.calibrated));
    row.set("after", number_or_null(one.found));
    const Node change = change_node(one.change);
    for (const Member& m : change.object()) row.set(m.key, m.value);
    out.push_back(std::move(row));
  }
  return Node(std::move(out));
}

/// What effects are, in the words of their plugins.
Node words_of_effects(const Registry& registry) {
  Node out = Node::empty_object();
  for (const PluginEntry& entry : registry.entries()) {
    if (entry.decl->kind != abi::Kind::effect) continue;
    Node params = Node::empty_object();
    for (const abi::ParamDecl& p : entry.params()) {
      Node one = Node::empty_object();
      one.set("words", Node(std::string(p.doc)));
      one.set("unit", Node(std::string(p.unit)));
      params.set(p.name, std::move(one));
    }
    Node effect = Node::empty_object();
    effect.set("words", Node(std::string(entry.decl->summary)));
    effect.set("params", std::move(params));
    out.set(entry.decl->id, std::move(effect));
  }
  return out;
}

/// What the report tells beside diagnosis.json.
Node report_of(const Diagnosis& d, const RealDiagnosis& asked, const Registry& registry,
               const std::list<measured::SessionFile>& files) {
  Node out = Node::empty_object();
  out.set("sentence", Node(d.sentence));
  std::string logs;
  Node::Array health;
  constexpr std::array<const char*, 3> levels = {"good", "note", "bad"};
  for (const measured::SessionFile& file : files) {
    const std::string name = fs::path(file.session.name).filename().string();
    logs += (logs.empty() ? "" : ", ") + name;
    for (const measured::Finding& f : measured::health_of(file)) {
      Node row = Node::empty_object();
      row.set("check", Node(name + ": " + f.check));
      row.set("found", Node(f.found));
      row.set("done", Node(f.done));
      row.set("level", Node(levels[static_cast<std::size_t>(f.level)]));
      health.push_back(std::move(row));
    }
  }
  out.set("log", Node(logs));
  out.set("world", Node(asked.world));
  out.set("effects", words_of_effects(registry));
  out.set("health", Node(std::move(health)));
  return out;
}

/// What the effects that were fitted do by themselves, the largest gain first.
void print_tried(const MissingEffects& found) {
  std::cout << "\nalone               squared error, fitted   predictions of the same logs' time not fitted\n";
  std::vector<calibrate::RankedEffect> tried;
  std::ranges::copy_if(found.ranking, std::back_inserter(tried), &calibrate::RankedEffect::tried);
  std::ranges::stable_sort(tried, std::greater<>(), &calibrate::RankedEffect::gain);
  for (const calibrate::RankedEffect& r : tried) {
    char row[120];
    std::snprintf(row, sizeof row, "%-18s %+18.1f %%   %+7.1f %% (%+.1f to %+.1f): %s\n", r.effect.c_str(),
                  -100.0 * r.gain, 100.0 * r.change.change, 100.0 * r.change.low, 100.0 * r.change.high,
                  std::string(change_of(r.change).says()).c_str());
    std::cout << row;
  }
}

/// What calibration, beside the effects named, made of the world's own parameters that the logs determine.
void print_calibrated(const MissingEffects& found) {
  std::string rows;
  for (const calibrate::FittedParameter& p : found.parameters) {
    const calibrate::Unknown& u = p.unknown;
    const bool named = std::ranges::any_of(found.named, [&](const calibrate::MissingEffect& n) {
      return u.pointer.starts_with(calibrate::pointer_of(n.effect, ""));
    });
    if (u.observer || named) continue;
    rows += format("%-45s %10.4g %10.4g   %.4g to %.4g\n", u.pointer.c_str(), u.prior, p.value, p.interval.low,
                   p.interval.high);
  }
  if (!rows.empty())
    std::cout << "\ncalibrated                                         start      found   95 %\n" << rows;
}

void print_real(const Diagnosis& d, const MissingEffects& found) {
  std::cout << d.sentence << "\n\nverdict: unknown\n";
  if (!found.named.empty()) std::cout << "\nmissing             predictions of time not fitted, beside the others\n";
  for (const calibrate::MissingEffect& n : found.named) {
    char row[160];
    std::snprintf(row, sizeof row, "%-18s %+7.1f %% (%+.1f to %+.1f)", n.effect.c_str(), 100.0 * n.change.change,
                  100.0 * n.change.low, 100.0 * n.change.high);
    std::cout << row;
    for (const auto& v : n.params) std::cout << "   " << v.text(4, true);
    std::cout << '\n';
  }
  print_calibrated(found);
  print_tried(found);
  if (!found.named.empty()) {
    std::cout << "\nlog                              calibrated  with effects   change, of time not fitted\n";
    for (const calibrate::SessionChange& one : found.sessions) {
      char row[160];
      std::snprintf(row, sizeof row, "%-32s %10.3f %13.3f   %+.1f %% (%+.1f to %+.1f)\n",
                    fs::path(one.log).filename().string().c_str(), one.calibrated, one.found, 100.0 * one.change.change,
                    100.0 * one.change.low, 100.0 * one.change.high);
      std::cout << row;
    }
  }
  std::cout << "\nerrors 1 s ahead, of time not fitted (95 % by blocks of 10 s)\n";
  calibrate::print_horizon_table(std::cout, found.rows);
}

}  // namespace

int diagnose_real(const RealDiagnosis& asked, const LogWorld& world, const measured::LogMap& map,
                  const Registry& registry) {
  const double v_ref = world.spec.car.car.v_ref;
  auto files = read_sessions(asked.logs, map, v_ref), held_out = read_sessions(asked.held_out, map, v_ref);
  check_distinct(files, held_out);
  const OutLock lock = open_out_folder(asked.out, "diagnosis", asked.force);
  const auto delays = channel_delays(files, map, world.spec, asked.out);
  calibrate::MissingOptions options;
  options.fit.slowest = calibrate::slowest_start(world.spec);
  options.fit.crawling = world.spec.car.car.v_min;
  const MissingEffects found = [&] {
    const StopSignal stop(StopSignal::Reaction::end, run_broke);
    CallbackProgress progress(std::cerr, "diagnose");
    constexpr std::size_t parts = 100;
    const auto callback = progress.callback();
    options.progress = [&](double share, const std::string& what) {
      callback(static_cast<std::size_t>(share * parts), parts, what);
    };
    MissingEffects all =
        calibrate::find_missing(world.tree, world.spec, registry, map, files, held_out, options, asked.out);
    progress.finish();
    return all;
  }();
  const Cornering corners = cornering_of(files, world.spec, found);
  const Diagnosis d = diagnosis_of(found, delays, corners);
  print_real(d, found);
  Node json = diagnose::diagnosis_json(d);
  json.find("gap")->set("calibrated", number_or_null(found.calibrated));
  json.find("gap")->set("noise", number_or_null(found.noise));
  json.find("gap")->set("at_noise", Node(found.at_noise()));
  json.find("gap")->set("judged", number_or_null(found.judged));
  json.find("gap")->set("calibration", change_node(found.calibration));
  json.find("gap")->set("effects", found.named.empty() ? Node::null() : change_node(found.change));
  json.find("gap")->set("sessions", found.named.empty() ? Node::null() : sessions_node(found.sessions));
  json.set("understeer", understeer_node(corners));
  write_file(asked.out / "diagnosis.json", to_json_text(json));
  Node augmented = found.world;
  augmented.set("note", Node(d.sentence));
  write_file(asked.out / "augmented_world.json", to_json_text(augmented));
  std::cout << "\ndiagnosis: " << (asked.out / "diagnosis.json").string()
            << "\nworld with what was found: " << (asked.out / "augmented_world.json").string() << '\n';
  write_file(asked.out / "diagnosis_report.json", to_json_text(report_of(d, asked, registry, files)));
  if (!report_results(asked.out)) return run_broke;
  return is_answer(d, found) ? good : claim_failed;
}

}  // namespace gripline::tools
