// Maximum likelihood of a model on logs: parameters by Gauss-Newton on the filter's innovations, the variances of the
// unknown accelerations by Fisher scoring in the same iterations.
#pragma once

#include <algorithm>
#include <limits>
#include <memory>

#include "diagnose/inference/filter.hpp"
#include "diagnose/model/directions.hpp"

namespace gripline::diagnose {

/// Everything the search works on. The traces' reference may be renewed, and the penalty follows the road that is found;
/// nothing else changes.
struct Problem {
  const Catalogue* catalogue = nullptr;
  std::vector<Trace> traces;
  Channels sensor{};                                // standard deviations of the readings
  std::array<double, noise_states> process_unit{};  // usual size of unknown accelerations: 0.1 m/s2, and that over L
  int substeps = 2;
  double penalty_per_parameter = 0;  // half the logarithm of the number of readings that tell something of their own
  std::size_t rows = 0;
  /// Whether shapes along the lap are drawn to where they do nothing, by their parameters' scales: where no data are they
  /// would be anything.
  bool calm_shapes = false;

  /// What the parameters of one effect cost. Schwarz's penalty for each is that of a parameter that could be anything;
  /// beyond three they give one effect its shape along the lap. Chi-squares of equal significance grow by about one unit
  /// of log likelihood per degree of freedom, and two are charged.
  double charge(std::size_t parameters) const {
    const std::size_t shape = parameters - std::min(parameters, full_charge);
    return penalty_per_parameter *
           (static_cast<double>(parameters - shape) + shape_charge * static_cast<double>(shape));
  }
  static constexpr std::size_t full_charge = 3;
  static constexpr double shape_charge = 0.4;
  /// Time of all traces together [s].
  double seconds() const;
};

/// How random each acceleration is, in its usual size.
std::array<double, noise_states> roughness(const Problem& problem, const Noise& noise);
/// Whether the car drives on a rough road: all three accelerations are random by a fifth of their usual size or more.
/// What a model lacks is mostly seen as noise in one or two of them.
bool rough_road(const Problem& problem, const Noise& noise);

struct Evaluation;  // of a model at its parameters: see fit.cpp

/// A model with its best parameters.
struct Fit {
  ModelSpec model;
  Noise noise;
  double cost = 0;            // minus log likelihood plus half the squared deviations of what is believed beforehand
  std::size_t free = 0;       // effect parameters that the data determine (rank)
  double penalty = 0;         // for its effects' parameters
  double score = 0;           // -cost - penalty: differences are log evidence (Schwarz)
  std::vector<double> theta;  // free parameters: nuisances, then the members' in order
  std::vector<double> covariance;  // theta x theta
  bool converged = false;
  bool finished = false;  // nothing is gained by going on
  /// Of this model along the references and with the beliefs it was fitted with; null when it could not be evaluated.
  std::shared_ptr<const Evaluation> evaluation;
  double work = 0;  // that it took: see Linearised::work, times samples
};

/// Sets a fit's penalty and score by what parameters cost now.
void charge_for(const Problem& problem, Fit& fitted);

/// A model along every trace.
std::vector<Linearised> linearise_all(const Problem& problem, const ModelSpec& model);

/// Free parameters of a model as a vector, and back.
std::vector<double> pack(const Catalogue& catalogue, const ModelSpec& model);
void unpack(const Catalogue& catalogue, std::span<const double> theta, ModelSpec& model);

/// When a fit may stop before its iterations are used up.
struct FitLimits {
  double tolerance = 0.01;  // log likelihood that may be left unfound
  /// Score that it must be able to reach to be of interest.
  double wanted = -std::numeric_limits<double>::infinity();
};

/// Fits from the given values and variances. Where random accelerations remain it is tried whether none would do as well:
/// parameters that are not there yet look like randomness, and the way down is long and flat.
Fit fit(const Problem& problem, const ModelSpec& start, const Noise& noise, int iterations = 8,
        const FitLimits& limits = {});
/// Goes on from where a fit ended, on the same problem.
Fit go_on(const Problem& problem, const Fit& from, int iterations, const FitLimits& limits);

/// Replaces the traces' reference by the trajectory smoothed with a fitted model. Returns by how much it moved: root mean
/// square in sensor standard deviations.
double renew_reference(Problem& problem, const Road& road, const Fit& fitted);
/// The same until it stands still: a channel that nobody read starts far off.
void settle_reference(Problem& problem, const Road& road, const Fit& fitted);

}  // namespace gripline::diagnose
