// Perturbed races: every seed draws its own start pose, start speed and, if asked for, pace, the same for all stacks,
// so that rows are compared on the same draws.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "race/stack.hpp"
#include "world/world_spec.hpp"

namespace gripline {

/// Half widths of uniform distributions around what the experiment says; 0: not perturbed.
struct PerturbSpec {
  double position = 0.0;  // along and across the car at the start, each [m]
  double heading = 0.0;   // [rad]
  double speed = 0.0;     // [m/s]
  double pace = 0.0;      // of the planner's parameter of that name, as a share of it
  bool any() const { return position > 0 || heading > 0 || speed > 0 || pace > 0; }
};

/// {"position": "20 mm", "heading": "3 deg", "speed": "0.1 m/s", "pace": 0.03}. The starts that the extremes give must
/// lie on the road; with "within_road": true, `position` is what leaves the car's body on it, if that is less. With
/// "pace" every planner must have that parameter and allow the extremes.
PerturbSpec read_perturb(const Node& node, const WorldSpec& world, const std::vector<StackSpec>& stacks,
                         Errors& errors);

/// What one seed draws.
struct Draw {
  double along = 0.0, across = 0.0;  // [m], to the front and to the left of the start
  double heading = 0.0;              // [rad]
  double speed = 0.0;                // [m/s]
  double pace = 1.0;                 // factor
};
/// A quantity's draw depends on the seed and on its own width only.
Draw draw_of(const PerturbSpec& spec, std::uint64_t seed);
Pose moved_start(const Pose& start, const Draw& draw);
/// Puts the draw of a seed into the world and the stack of its run; empty when nothing is perturbed.
std::optional<Draw> perturb(const PerturbSpec& spec, std::uint64_t seed, WorldSpec& world, StackSpec& stack);

/// `count` different seeds from the SHA-256 of a text, such as the hash of the commit that froze the settings, so that
/// nobody can select them.
std::vector<std::uint64_t> seeds_from(std::string_view text, std::size_t count);

/// Refuses (InputError, at its place) seeds that are drawn from a text where the friction of a world in this experiment
/// comes later with the seed (shift_per_seed): drawn seeds are so large that it would not change within any race.
void require_drawn_seeds_fit(const Node& experiment, std::string_view text);

}  // namespace gripline
