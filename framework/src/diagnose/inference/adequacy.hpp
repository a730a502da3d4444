// Is anything left that no effect of the model explains, and where does it live? A joint score test of generic
// accelerations: smooth functions of place, of time, of the state and of the inputs.
#pragma once

#include <span>
#include <string>

#include "diagnose/inference/fit.hpp"

namespace gripline::diagnose {

enum class Where { position, time, state, input };
inline constexpr std::array<const char*, 4> where_names = {"position", "time", "state", "input"};

struct BasisTest {
  Where where = Where::position;
  double gain = 0;  // rise of the log likelihood with all its functions in
  std::size_t dof = 0;
  /// (2 gain - dof) / sqrt(2 dof): a standard normal when nothing is left.
  double excess = 0;
  /// Where along the basis' own axis the remainder is largest; for state and input the range of the quantity named.
  double from = 0, to = 0;
  std::string quantity;
  /// A test of few functions: it sees small remainders of simple shape, and says less about where they live.
  bool focused = false;
  /// Largest of its accelerations there, per channel [m/s2, m/s2, rad/s2].
  std::array<double, 3> size{};
};

/// One test per kind, in the order of Where, then one of random accelerations in some directions only (quantity "noise",
/// of the kind of the strongest before it), one of rhythms in time (quantity "frequency", from and to in Hz), then the focused
/// ones.
inline constexpr double structured = 4.0;  // excess of a test beyond which something is left
/// The strongest test; a focused one only when no other finds anything.
const BasisTest& strongest(std::span<const BasisTest> tests);
std::vector<BasisTest> remainder(const Problem& problem, const Fit& fitted);

/// For each member of the model: log evidence that it is there even if all functions of one kind are (Wald's test minus
/// the penalty of its parameters). `along` as for score_system. Negative: the generic functions explain what it explained.
std::vector<double> support_beside(const Problem& problem, const Fit& fitted, std::span<const Linearised> along,
                                   Where where);

}  // namespace gripline::diagnose
