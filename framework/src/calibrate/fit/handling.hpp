// What a fitted car is like, whatever its parameters are called: friction of its tyres, and how it corners.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "car/staged_car.hpp"
#include "measured/estimates/steady_turning.hpp"

namespace gripline::calibrate {

/// Peak lateral force over static load, as the fitted model has it.
struct Friction {
  bool known = false;  // the model has tyres
  double front = 0, rear = 0, total = 0, total_low = 0, total_high = 0;
};

/// Friction of a car with these parameters (all of a forecaster of it, or the car's own); the interval holds 95 % of
/// the draws of either kind.
Friction friction_of(const StagedCar& car, const Car& constants, std::span<const double> params,
                     std::span<const std::vector<double>> bootstrap_draws,
                     std::span<const std::vector<double>> posterior_draws = {});

/// Understeer angle [rad]: by how much more than L / R the road wheels are turned in a steady corner, the difference
/// between the slip angles of the axles (Milliken and Milliken, Race Car Vehicle Dynamics, section 5.3), so that a
/// wrong steering ratio or offset is not in it. Of the sign of `omega` where the car understeers. Without drive, on a
/// flat road; `params` as above, `vx` [m/s], `omega` [rad/s]. Empty where the model has no tyres, or where no
/// steering keeps it in such a corner.
std::optional<double> understeer_angle(const StagedCar& car, std::span<const double> params, double vx, double omega);

/// The understeer gradient that this car would show in the corners of logs [rad s2/m]; empty where it cannot stay
/// in one of them.
std::optional<double> gradient_in(const measured::SteadyTurning& logs, const StagedCar& car,
                                  std::span<const double> params);

/// For people: "In gentle corners the car understeers by 0.5 deg/g (0.4 to 0.6); the world given agrees, it understeers
/// by 0.45 deg/g." The second half says "does not agree" where `given`, the gradient of that world in the same corners,
/// lies outside the interval, and is left out where there is none.
std::string corners_text(const measured::SteadyTurning& logs, const std::optional<double>& given);
/// "understeer: not determined by these logs; " and why (TurningByLogs).
std::string no_understeer_text(const std::string& why_not);

}  // namespace gripline::calibrate
