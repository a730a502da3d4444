// gripline fit WORLD.json LOG... --out FITTED.json: a world's unknowns, so that its predictions miss the logs least.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <list>
#include <optional>
#include <span>

#include "calibrate/effects/advice.hpp"
#include "calibrate/effects/start_of_fit.hpp"
#include "calibrate/effects/yaw_limit.hpp"
#include "config/errors.hpp"
#include "config/json_file.hpp"
#include "config/shipped.hpp"
#include "gripline/command.hpp"
#include "gripline/log_options.hpp"
#include "measured/estimates/steady_turning.hpp"
#include "measured/session/centre_of_gravity.hpp"
#include "measured/session/session_checks.hpp"
#include "util/numbers.hpp"
#include "util/progress.hpp"
#include "util/signals.hpp"
#include "util/whole_file.hpp"

namespace gripline::tools {
namespace po = boost::program_options;
namespace fs = std::filesystem;
namespace {

using calibrate::FitResult;
using calibrate::FittedParameter;

std::string unit_text(const std::string& unit) { return unit.empty() || unit == "1" ? "" : unit; }

void print_parameters(const FitResult& result, std::span<const calibrate::ParameterPlace> places) {
  std::size_t width = 9;
  for (const FittedParameter& p : result.parameters) width = std::max(width, p.unknown.pointer.size());
  std::cout << "\nparameter" << std::string(width - 7, ' ')
            << "value        95 %                       prior        unit\n";
  for (const FittedParameter& p : result.parameters) {
    const char* const remark = p.status == FittedParameter::Status::determined     ? ""
                               : p.status == FittedParameter::Status::undetermined ? "  undetermined: kept at its prior"
                                                                                   : "  at its bound: kept there";
    std::string line = p.unknown.pointer + std::string(width + 2 - p.unknown.pointer.size(), ' ') +
                       format("%-12.6g (%.4g .. %.4g)", p.value, p.interval.low, p.interval.high);
    line += std::string(line.size() < width + 42 ? width + 42 - line.size() : 1, ' ');
    const auto place = std::ranges::find(places, p.unknown.pointer, &calibrate::ParameterPlace::pointer);
    std::string unit = place == places.end() ? "" : unit_text(place->unit);
    unit.resize(std::max<std::size_t>(unit.size(), *remark != '\0' ? 7 : 0), ' ');
    std::string end = format("%-12.6g %s%s", p.unknown.prior, unit.c_str(), remark);
    end.erase(end.find_last_not_of(' ') + 1);
    std::cout << line << end << '\n';
  }
}

/// Bounds and prior that stand in no file of the user's.
void print_limited(const calibrate::Unknown& u, const measured::YawRateOffset& by_yaw) {
  std::cout << u.pointer << ": " << significant(by_yaw.value) << " rad/s by the logs' own yaw; bounds "
            << significant(u.low) << " and " << significant(u.high) << " rad/s, prior " << significant(u.prior)
            << " rad/s\n";
}

void print(const FitResult& result, double horizon, std::span<const calibrate::ParameterPlace> places) {
  std::cout << "\nerrors at " << horizon << " s on the fitted logs themselves (in-sample), root mean square over "
            << result.starts << " starts (95 % by blocks of 10 s)\n";
  calibrate::print_horizon_table(std::cout, result.errors);
  print_parameters(result, places);
  if (result.friction.known)
    std::cout << format("\nfriction: %.3f (%.3f .. %.3f); front %.3f, rear %.3f\n", result.friction.total,
                        result.friction.total_low, result.friction.total_high, result.friction.front,
                        result.friction.rear);
  if (result.dropped > 0) std::cout << result.dropped << " errors too large to count were left out\n";
  if (!result.advice.empty()) std::cout << "\nwhat else would help (to first order, not in the world)\n";
  std::size_t shown = 0;
  for (const calibrate::Advice& a : result.advice) {
    if (++shown > 5) break;
    std::cout << format("  %-20s %5.1f %% less squared error, %.1f standard deviations", a.effect.c_str(),
                        100.0 * a.gain, a.score);
    constexpr std::size_t most = 3;  // shapes along the lap have ten
    const std::size_t told = a.values.size() > most ? 1 : a.values.size();
    for (const calibrate::Advice::Value& v : std::span(a.values).first(told)) {
      const std::string unit = unit_text(v.unit);
      std::cout << format(", %s = %.3g%s%s", v.name.c_str(), v.value, unit.empty() ? "" : " ", unit.c_str());
    }
    if (told < a.values.size()) std::cout << " and " << a.values.size() - told << " more";
    std::cout << '\n';
  }
}

/// How the car answers its steering, by the logs and by the fitted world.
void print_cornering(const std::list<measured::SessionFile>& files, const Car& car, const StagedCar& model,
                     std::span<const double> params, const measured::TurningLateness& late) {
  std::list<measured::Session> own;
  std::vector<const measured::Session*> sessions;
  for (const measured::SessionFile& file : files) sessions.push_back(&own.emplace_back(at_centre_of_gravity(file)));
  const auto [by_logs, why_not] = measured::steady_turning(sessions, car.lf + car.lr, car.v_ref, late);
  if (!by_logs) {
    std::cout << calibrate::no_understeer_text(why_not) << '\n';
    return;
  }
  std::cout << "in gentle corners of the logs the car " << by_logs->text();
  if (const auto fitted = calibrate::gradient_in(*by_logs, model, params))
    std::cout << "; the fitted world " << measured::cornering_text(*fitted);
  std::cout << '\n';
}

/// Evidence that the log is not of this car: the fitted model predicts no better than persistence.
void warn_when_useless(const FitResult& result) {
  const auto row = [&](const char* name) {
    return std::find_if(result.errors.begin(), result.errors.end(), [&](const auto& r) { return r.name == name; });
  };
  const auto fitted = row("fitted"), persistence = row("persistence");
  const bool place = fitted->error[0].count > 0;
  const std::size_t q = place ? 0 : 4;
  if (fitted->error[q].rms < persistence->error[q].rms) return;
  std::cerr << "the fitted world misses by " << fitted->error[q].rms << ' ' << calibrate::quantity_names[q]
            << ", persistence (constant velocities) by " << persistence->error[q].rms
            << ": is this a log of another car, or are units or signs of the map wrong?\n";
}

/// Parameters that the logs put far outside of their priors: of another car, or of a wrong map.
void warn_when_far(const FitResult& result) {
  constexpr double far = 3.0;  // standard deviations of the prior
  std::string found;
  for (const FittedParameter& p : result.parameters) {
    if (p.status != FittedParameter::Status::determined || p.unknown.observer) continue;
    const calibrate::Unknown& u = p.unknown;
    const double off = u.log ? std::log(p.value / u.prior) : p.value - u.prior;
    if (!(std::abs(off) > far * u.sigma)) continue;
    found += format("%s%s %.3g (the world's prior is %.3g, %.1f standard deviations away)", found.empty() ? "" : ", ",
                    u.pointer.c_str(), p.value, u.prior, std::abs(off) / u.sigma);
  }
  if (!found.empty())
    std::cerr << "fitted far outside of its prior: " << found
              << ": is this a log of another car, or are units, signs or frames of the map wrong?\n";
}

std::optional<po::variables_map> parse_fit_words(Arguments args) {
  po::options_description visible("options");
  add_log_options(visible);
  auto add = visible.add_options();
  add("out", po::value<std::string>()->default_value("fitted.json"), "the fitted world");
  add("fit", po::value<std::string>(),
      "groups or parameters, separated by commas: tyres,/plant/params/Iz; default: all");
  add("starts", po::value<std::string>()->default_value("200"),
      "predictions compared, of all logs together, 20 or more");
  add("seed", po::value<std::string>()->default_value("1"), "of the tries and of the intervals");
  add("quiet", po::bool_switch(), "no progress on stderr");
  add_plugins_option(visible);
  add("help,h", "this text");
  return parse_options(args, visible, "fit WORLD.json LOG... [--map MAP.json] --out FITTED.json", "world-and-logs");
}

/// The groups or parameters to fit; none where all of them are.
Words chosen_unknowns(const po::variables_map& given) {
  const auto text = text_of(given, "fit");
  return text ? names_of("--fit", *text, "group or parameter") : Words{};
}

/// The logs, each checked; what they hardly tell is said.
std::list<measured::SessionFile> read_fit_logs(std::span<const std::string> names, const measured::LogMap& map,
                                               const Car& car) {
  std::list<measured::SessionFile> files;
  for (const std::string& name : names) {
    files.push_back(measured::read_session(name, map));
    measured::check_session(files.back(), car.v_ref, car.delta_max);
    warn_of_findings(name, files.back());
    warn_of_inconsistencies(name, files.back());
  }
  return files;
}

calibrate::FitOptions fit_options_of(const po::variables_map& given, const WorldSpec& world) {
  calibrate::FitOptions fit;
  fit.slowest = calibrate::slowest_start(world);
  fit.crawling = world.car.car.v_min;
  constexpr std::int64_t most_seed = std::numeric_limits<decltype(fit.seed)>::max();
  fit.starts = static_cast<std::size_t>(whole_number("--starts", given["starts"].as<std::string>(), {20, 100000}));
  fit.seed = static_cast<unsigned>(whole_number("--seed", given["seed"].as<std::string>(), {0, most_seed}));
  if (!given["quiet"].as<bool>()) fit.print = [](const std::string& line) { std::cerr << line << '\n'; };
  return fit;
}

/// What a fit is of.
struct FitSubject {
  const LogWorld& world;
  const measured::LogMap& map;
  const std::list<measured::SessionFile>& files;
  const calibrate::Trial& given;
};

/// The fit, with its progress on stderr unless `quiet`; where `registry` is given, with advice on effects of it.
FitResult fit_with_progress(const FitSubject& of, const std::optional<measured::YawRateOffset>& by_yaw,
                            const calibrate::StartOfFit& start, calibrate::FitOptions options, bool quiet,
                            const Registry* registry) {
  const WorldSpec& world = of.world.spec;
  const calibrate::Forecaster& forecaster = of.given.forecaster;
  const calibrate::ForecastOptions& forecast = forecaster.options();
  std::vector<calibrate::FitLog> logs = calibrate::fit_logs(of.files, world.track, forecast.step, options);
  CallbackProgress progress(std::cerr, "fit");
  constexpr std::size_t parts = 100;
  if (!quiet)
    options.progress = [callback = progress.callback()](double share, const std::string& what) {
      callback(share * parts, parts, what);
    };
  FitResult result = calibrate::fit(forecaster, logs, start.values, start.unknowns, options);
  if (registry != nullptr) result.advice = calibrate::advise(world, *registry, forecast, logs, result, by_yaw);
  result.friction = calibrate::friction_of(of.given.vehicle.car(), world.car.car, result.params, result.bootstrap_draws,
                                           result.posterior_draws);
  progress.finish();
  return result;
}

void write_fitted(const FitSubject& of, const FitResult& result, const fs::path& out) {
  calibrate::FitSource source;
  for (const measured::SessionFile& file : of.files) source.logs.push_back(file.session.name);
  source.map = of.map.file.filename().string();
  write_file(out, to_json_text(calibrate::fitted_world(of.world.tree, of.world.spec, of.given.forecaster, result,
                                                       source, out.parent_path())));
  std::cout << "\nworld: " << out.string() << '\n';
}

}  // namespace

int run_fit(Arguments args) {
  const auto given = parse_fit_words(args);
  if (!given) return good;
  Words words = words_of(*given, "world-and-logs");
  if (words.size() < 2)
    throw InputError("fit needs a world and a log: gripline fit WORLD.json LOG... --out FITTED.json");
  words[0] = find_shipped(words[0], "worlds").string();
  const fs::path out = (*given)["out"].as<std::string>();
  require_writable("--out", out, words);
  const Words chosen = chosen_unknowns(*given);
  const Registry registry = open_registry(plugin_dirs_of(*given));
  const LogWorld world = read_log_world(words[0], *given, registry);
  const calibrate::FitOptions fit = fit_options_of(*given, world.spec);  // what is wrong there, before logs are read
  const measured::LogMap map = map_option(*given, world.spec);

  const auto files = read_fit_logs(std::span(words).subspan(1), map, world.spec.car.car);
  calibrate::ForecastOptions options = calibrate::forecast_options(world.spec);
  options.own_commands = false;
  const calibrate::Trial given_world(world.spec, options);

  const FitSubject subject{world, map, files, given_world};
  const auto by_yaw = calibrate::offset_by_yaw(files);
  const calibrate::StartOfFit start = calibrate::start_of_fit(world.tree, given_world, map, files, by_yaw, chosen);
  for (const calibrate::Unknown& u : start.limited) print_limited(u, *by_yaw);
  const StopSignal stop(StopSignal::Reaction::end);
  const FitResult result = fit_with_progress(subject, by_yaw, start, fit, (*given)["quiet"].as<bool>(),
                                             chosen.empty() ? &registry : nullptr);

  print(result, fit.horizons.back(), given_world.places);
  print_cornering(files, world.spec.car.car, given_world.vehicle.car(), result.params,
                  calibrate::turning_lateness(given_world.forecaster, result.params, result.parameters));
  warn_when_useless(result);
  warn_when_far(result);
  write_fitted(subject, result, out);
  return good;
}

}  // namespace gripline::tools
