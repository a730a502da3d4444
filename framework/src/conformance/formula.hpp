// Plugins that are formulas (vehicle models, effects, estimators' corrections) as functions from numbers to numbers,
// for derivatives against differences and batches against single points.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <gripline/interfaces.hpp>

#include "plugin/registry.hpp"

namespace gripline::conformance {

/// A formula of some numbers per instant and of parameters shared by all instants, with as many numbers per instant as
/// answer. Instants evaluated together stand row after row.
class Formula {
 public:
  virtual ~Formula() = default;
  virtual std::vector<std::string> inputs() const = 0;
  virtual std::vector<std::string> outputs() const = 0;
  /// Parameters that are numbers, by name; their values are those the formula was made with.
  virtual const std::vector<std::string>& params() const = 0;
  virtual const std::vector<double>& values() const = 0;
  /// n instants in one call of the plugin; `first`: number of the first among the places of the road.
  virtual std::vector<double> evaluate(std::size_t n, const std::vector<double>& rows,
                                       const std::vector<double>& params, std::size_t first = 0) const = 0;
  virtual std::vector<Dual8> evaluate(std::size_t n, const std::vector<Dual8>& rows, const std::vector<Dual8>& params,
                                      std::size_t first = 0) const = 0;
  /// A call of no instants at all.
  virtual void evaluate_none() const = 0;

  /// Calls with double and with Dual8 on instants kept for it; a call makes no allocation of the kit's.
  class Prepared {
   public:
    virtual ~Prepared() = default;
    virtual void run() = 0;
  };
  virtual std::unique_ptr<Prepared> prepare(std::size_t n, const std::vector<double>& rows) const = 0;
};

/// The formula of an instance: a VehicleModel*, an Effect* or an Estimator* as `kind` says, not owned.
std::unique_ptr<Formula> formula_of(abi::Kind kind, const void* instance, const PluginEntry& entry,
                                    const std::vector<abi::ParamValue>& values);

/// Rows of operating points of a 1:43 car, drawn from `seed`: driving, sliding, steering; all quantities different.
std::vector<double> driving_rows(const Formula& formula, std::size_t n, unsigned seed);
/// Rows of extreme operating points: standstill, reverse, full lock, spinning, sideways.
std::vector<double> edge_rows(const Formula& formula);
inline constexpr std::size_t edge_count = 6;
/// Words for one of them.
const char* edge_name(std::size_t row);

/// The first number by which a batch differs from its instants one by one, in words; empty when none does.
std::string batch_problem(const Formula& formula);

/// The first derivative that differs from central differences, or the first value that differs between double and
/// Dual8, in words; empty when all agree.
std::string derivative_problem(const Formula& formula);

}  // namespace gripline::conformance
