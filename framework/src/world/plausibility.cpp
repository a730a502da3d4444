#include "world/plausibility.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "util/child_process.hpp"
#include "util/numbers.hpp"
#include "world/world.hpp"

namespace gripline {
namespace {

// Bounds of what is driven: models of cars in 1:43 (6 cm) to lorries; tyres on ice to slicks with downforce.
constexpr double shortest = 0.01, longest = 30.0;         // [m]
constexpr double least_grip = 0.05, most_grip = 5.0;      // peak lateral axle force over the axle's static load
constexpr double least_inertia = 0.1, most_inertia = 10;  // Iz over m lf lr, which is near 1 for cars
constexpr double most_friction_factor = 3.0;              // 1 is the fresh road; percent would be 100
// The Nordschleife is 4800 cars long, and the widest circuits are some 10 cars wide.
constexpr double most_car_lengths = 10000.0, most_car_widths = 40.0;

using Warnings = std::vector<Diagnostic>;

/// Where the value at a pointer below `node` is written, else the nearest one that is there above it.
const Origin& written_at(const Node& node, const std::string& pointer) {
  const Node* const found = find_pointer(node, pointer);
  if (found != nullptr || pointer.empty()) return (found != nullptr ? *found : node).origin;
  return written_at(node, pointer.substr(0, pointer.rfind('/')));
}

/// Adds warnings at their places in the tree that what is checked was read from.
class Warner {
 public:
  Warner(const Node& node, Warnings& warnings) : node_(node), warnings_(warnings) {}
  void add(const std::string& pointer, std::string message) {
    warnings_.push_back(diagnostic_at(written_at(node_, pointer), std::move(message)));
  }

 private:
  const Node& node_;
  Warnings& warnings_;
};

std::string text_of(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value, std::chars_format::general, 4).ptr};
}

/// The least and the largest factor that a schedule names; what falls step by step has no least.
std::pair<double, double> factors_of(const FrictionSpec& friction) {
  double lo = 1.0, hi = 1.0;
  const auto by_factor = [](const auto& a, const auto& b) { return a.factor < b.factor; };
  if (!friction.points.empty()) {
    const auto [least, most] = std::minmax_element(friction.points.begin(), friction.points.end(), by_factor);
    lo = least->factor, hi = most->factor;
  }
  if (!friction.patches.empty()) {
    const auto [least, most] = std::minmax_element(friction.patches.begin(), friction.patches.end(), by_factor);
    lo *= std::min(1.0, least->factor), hi *= std::max(1.0, most->factor);
  }
  return {lo, hi};
}

/// The pointer of the factor that is largest, in a schedule that has one above 1.
std::string largest_factor(const FrictionSpec& friction, const Node& node) {
  const auto by_factor = [](const auto& a, const auto& b) { return a.factor < b.factor; };
  const auto largest = [&](const auto& list) { return std::max_element(list.begin(), list.end(), by_factor); };
  const auto point = largest(friction.points);
  const auto patch = largest(friction.patches);
  const double of_points = point != friction.points.end() ? point->factor : 0.0;
  const double of_patches = patch != friction.patches.end() ? patch->factor : 0.0;
  if (of_patches > of_points) return "/patches/" + std::to_string(patch - friction.patches.begin()) + "/factor";
  return (node.is_array() ? "/" : "/points/") + std::to_string(point - friction.points.begin()) + "/factor";
}

/// Peak lateral force over static load of the front and of the rear axle at factor 1; 0 where the plant has no tyres,
/// empty where it could not be made. Throws std::runtime_error where no process can be started.
std::vector<double> grips_of(const WorldSpec& world) {
  constexpr double timeout_s = 10.0;
  const ChildResult result = run_in_child(timeout_s, [&](const SendMessage& send) {
    WorldSpec fresh = world;
    fresh.friction = {};
    const World driven(fresh, 1);
    for (const Axle axle : {Axle::front, Axle::rear}) send(number_text(driven.truth().mu(axle)));
  });
  std::vector<double> grips;
  if (result.completed)
    for (const std::string& text : result.messages)
      if (double grip = 0.0; std::from_chars(text.data(), text.data() + text.size(), grip).ec == std::errc())
        grips.push_back(grip);
  return grips;
}

void check_grip(const WorldSpec& world, Warner warn) {
  const auto [lo, hi] = factors_of(world.friction);
  std::vector<double> grips;
  try {
    grips = grips_of(world);
  } catch (const std::runtime_error& none) {  // what cannot be asked stops nothing
    warn.add("/plant",
             std::string("cannot tell whether the axles' peak lateral forces are those of tyres: ") + none.what());
    return;
  }
  const auto beyond = [](double grip) { return grip < least_grip || grip > most_grip; };
  for (std::size_t i = 0; i < grips.size(); ++i) {
    if (!(grips[i] > 0.0)) continue;
    std::string factor;
    double grip = grips[i];
    for (const double one : {lo, hi})
      if (!beyond(grips[i]) && beyond(grips[i] * one) && factor.empty())
        grip = grips[i] * one, factor = " at friction factor " + text_of(one);
    if (!beyond(grip)) continue;
    warn.add("/plant", std::string(i == 0 ? "the front" : "the rear") + " axle's peak lateral force is " +
                           text_of(grip) + " times its load" + factor + "; tyres have about " + text_of(least_grip) +
                           " to " + text_of(most_grip) + ": are mass, forces and factors in SI?");
  }
}

/// A road of another scale than the car; one that is narrower than the car is refused where the world is read.
void check_road(const WorldSpec& world, Warner warn) {
  constexpr const char* hint = "are both of one scale? gripline track --scale makes roads smaller or larger";
  const Car& car = world.car.car;
  const double lap = world.track->length(), width = world.track->narrowest();
  if (lap > most_car_lengths * car.length)
    warn.add("/track", format("a lap of the road is %.0f m, %.0f lengths of the car (%s m), more than %.0f: %s", lap,
                              lap / car.length, text_of(car.length).c_str(), most_car_lengths, hint));
  if (width > most_car_widths * car.width)
    warn.add("/track",
             format("the road is at least %s m wide, %.0f widths of the car (%s m), more than %.0f: %s",
                    text_of(width).c_str(), width / car.width, text_of(car.width).c_str(), most_car_widths, hint));
}

/// What noise and bias of a channel do not reach, and what is then said of it.
struct SensorBound {
  double most;
  std::string words;
  const char* degrees = "";  // the unit that was most likely left out
};

std::array<SensorBound, channel_count> sensor_bounds(const WorldSpec& world) {
  constexpr double most_yaw = 0.5;  // [rad] compasses and GPS headings are better than 29 degrees
  const double width = world.track->narrowest(), v_ref = world.car.car.v_ref, most_rate = gravity / v_ref;
  const SensorBound place = {width, "the road is wide (" + text_of(width) + " m)"};
  const SensorBound speed = {v_ref, "the car's typical speed v_ref (" + text_of(v_ref) + " m/s)"};
  return {place,
          place,
          {most_yaw, text_of(most_yaw) + " rad", "deg"},
          speed,
          speed,
          {most_rate, "a car turns at 1 g and its typical speed (" + text_of(most_rate) + " rad/s)", "deg/s"}};
}

void check_sensors(const WorldSpec& world, Warner warn) {
  const std::array<SensorBound, channel_count> bounds = sensor_bounds(world);
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    const auto& [name, unit] = sensor_channels[i];
    const SensorSpec::Channel& channel = world.sensors.channels[i];
    const auto& [most, words, degrees] = bounds[i];
    for (const auto& [what, value] : {std::pair("sigma", channel.sigma), {"bias", channel.bias}}) {
      if (!(std::abs(value) > most)) continue;
      std::string text = std::string("the sensors' ") + what + " of " + name + " is " + text_of(value) + " " + unit +
                         ", more than " + words;
      if (*degrees != '\0') text += "; degrees are written \"" + text_of(value) + " " + degrees + '"';
      warn.add(std::string("/sensors/") + what + "/" + name, std::move(text));
    }
  }
}

void check_car(const Car& car, Warner warn) {
  const std::pair<const char*, double> lengths[] = {
      {"lf", car.lf}, {"lr", car.lr}, {"length", car.length}, {"width", car.width}};
  for (const auto& [name, metres] : lengths)
    if (metres < shortest || metres > longest)
      warn.add(std::string("/") + name, std::string(name) + " is " + text_of(metres) + " m; cars have " +
                                            text_of(shortest) + " to " + text_of(longest) + " m");
  const double ratio = car.Iz / (car.m * car.lf * car.lr);
  if (ratio < least_inertia || ratio > most_inertia)
    warn.add("/Iz", "Iz is " + text_of(ratio) + " times m lf lr; of cars it is about that, within a factor of 10");
  constexpr double most_base = 1.5;  // axles apart over length; models in 1:43 with short bodies have 1.03
  if (car.lf + car.lr > most_base * car.length)
    warn.add("/length", "the axles are " + text_of(car.lf + car.lr) +
                            " m apart (lf + lr), more than the car is long (" + text_of(car.length) + " m)");
}

}  // namespace

std::vector<Diagnostic> plausibility_warnings(const Car& car, const Node& node) {
  Warnings warnings;
  check_car(car, {node, warnings});
  return warnings;
}

std::vector<Diagnostic> plausibility_warnings(const FrictionSpec& friction, const Node& node) {
  Warnings warnings;
  if (const double most = factors_of(friction).second; most > most_friction_factor)
    Warner(node, warnings)
        .add(largest_factor(friction, node),
             "the friction factor reaches " + text_of(most) + "; 1 is the fresh road, and factors above " +
                 text_of(most_friction_factor) + " exceed any real road's: is it in percent?");
  return warnings;
}

std::vector<Diagnostic> plausibility_warnings(const WorldSpec& world, const Node& node) {
  const auto part = [&](const char* key) -> const Node& {
    const Node* const found = node.find(key);
    return found != nullptr ? *found : node;
  };
  Warnings warnings = plausibility_warnings(world.car.car, part("car"));
  const Warnings friction = plausibility_warnings(world.friction, part("friction"));
  warnings.insert(warnings.end(), friction.begin(), friction.end());
  if (!world.track) return warnings;
  const Warner warn(node, warnings);
  check_grip(world, warn);
  check_road(world, warn);
  check_sensors(world, warn);
  return warnings;
}

}  // namespace gripline
