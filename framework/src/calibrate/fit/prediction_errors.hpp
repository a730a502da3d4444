// Errors of predictions at their horizons over many starts of several sessions, as a least-squares problem.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "calibrate/fit/unknowns.hpp"
#include "calibrate/forecast/forecaster.hpp"
#include "measured/session/session_file.hpp"

namespace gripline::calibrate {

/// What predictions are compared with: starts x horizons x 6. Between rows it is linear, also where a channel that is
/// read in few of them has its readings about as far apart as usual. NaN where nothing was read, for a channel that no
/// row up to the start had, and for a speed that is taken from the log, which is not a prediction.
std::vector<double> readings_at(const Session& session, const Starts& starts);

/// A session with what is asked of it.
struct FitLog {
  const Session* session = nullptr;
  measured::CommandGrid commands;
  std::shared_ptr<const Track> track;  // null: flat, no road
  Starts starts;
  std::vector<double> truth;  // readings_at(session, starts)
  double weight = 1;          // of its errors

  /// What a start's row needs: a speed in the half second before it; or one of its own, the start then being the next
  /// row that has one, unless the next start is due before.
  enum class Speed { lately, own };
  /// Starts every `every` seconds where |vx| is at least `slowest` and all horizons lie inside the log.
  FitLog(const Session& session, double grid_step, std::vector<double> horizons, double every, double slowest,
         Speed speed = Speed::lately);
};

/// The channels that the log has and none of whose readings a prediction is compared with, and what helps; else empty.
std::string never_compared(const FitLog& log);

/// Whether a part of a session that counts (a tenth) lies on a road, up to three half widths from its centre line.
bool lies_on(const Session& session, const Track& track);

/// How errors are weighed: over `scale` of their channel, times the horizon's weight, by the pseudo-Huber loss:
/// quadratic up to about `huber_delta` and linear beyond.
struct Weighing {
  std::array<double, channels> scale{1, 1, 1, 1, 1, 1};
  std::array<double, channels> channel{1, 1, 1, 1, 0.3, 1};
  std::vector<double> horizon;
  double huber_delta = 3;
  /// Errors that a standard deviation of an unknown moves by so many scales count half, steeper ones by the square
  /// less: where a car is about to spin its derivatives hold for a small part of such a move.
  double steep = std::numeric_limits<double>::infinity();
};

/// Normal equations by blocks of time, for bootstrap: every block is a stretch of one session, of `block_length` or, in
/// short logs, of a twentieth of them all, but of at least `shortest_block`. Both are of half the cost, which rises
/// along the gradient: summed, cost(move) ~ cost + 2 gradient' move + move' hessian move.
struct BlockedNormalEquations {
  std::vector<Eigen::MatrixXd> hessian;
  std::vector<Eigen::VectorXd> gradient;
  double cost = 0;
  std::size_t dropped = 0;    // errors left out: not finite, or of a derivative beyond all measure or that is no number
  std::size_t undefined = 0;  // of these: because a derivative is no number
};
inline constexpr double block_length = 10.0;   // [s]
inline constexpr double shortest_block = 2.0;  // [s]

class PredictionErrors {
 public:
  PredictionErrors(const Forecaster& forecaster, std::vector<FitLog>& logs) : forecaster_(forecaster), logs_(logs) {}

  Weighing weighing;

  /// Predictions less truth, by log: starts x horizons x 6.
  std::vector<std::vector<double>> errors(std::span<const double> params) const { return errors(params, nullptr); }
  /// `steps`, where given, receive those of the observer, by log, for linearise() at the same parameters.
  double cost(std::span<const double> params, std::vector<ObserverSteps>* steps = nullptr) const;
  /// Derivatives by the unknowns' own moves (logarithms where they move so). `steps` are those that cost() found at
  /// these very parameters, by log, or none; those of others give other predictions.
  BlockedNormalEquations linearise(std::span<const double> params, std::span<const Unknown> unknowns,
                                   std::vector<ObserverSteps> steps = {}) const;
  /// Scales from the errors of these parameters: root mean squares without the worst 3 %, x and y alike.
  void set_scales(std::span<const double> params);

  const Forecaster& forecaster() const { return forecaster_; }
  std::span<FitLog> logs() { return logs_; }
  std::span<const FitLog> logs() const { return logs_; }

 private:
  std::vector<std::vector<double>> errors(std::span<const double> params, std::vector<ObserverSteps>* steps) const;
  /// Predictions of a log, and their derivatives by the unknowns' moves: a row for each unknown.
  struct Predicted {
    std::vector<double> value;
    Eigen::MatrixXd slope;
  };
  Predicted predict_with_slopes(const FitLog& log, std::span<const double> params, std::span<const Unknown> unknowns,
                                ObserverSteps& steps) const;
  void add_blocks(const FitLog& log, const Predicted& predicted, std::span<const Unknown> unknowns, double length,
                  BlockedNormalEquations& to) const;
  double loss(double z, double weight, double* slope_weight) const;
  double weight_of(const FitLog& log, std::size_t k) const;

  const Forecaster& forecaster_;
  std::vector<FitLog>& logs_;
};

}  // namespace gripline::calibrate
