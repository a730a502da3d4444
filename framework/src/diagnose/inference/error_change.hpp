// Whether predictions of data not fitted become better with an effect, and how sure that is.
#pragma once

#include <string_view>
#include <vector>

namespace gripline::diagnose {

/// Squared errors of the predictions from each start, in sensor variances, and the number of readings they are of.
struct StartErrors {
  std::vector<double> square;
  std::vector<double> readings;
  /// Root mean square over all starts [sensor standard deviations]; 0 without any.
  double rms() const;
};

/// Relative change of the root mean square error, with its 95 % interval; negative: smaller with the effect.
struct ErrorChange {
  double change = 0;
  double low = -1, high = 1;
  /// Whether there were starts enough for an interval.
  bool measured() const { return low > -1.0 || high < 1.0; }
  bool helps() const { return high < 0.0; }
  bool harms() const { return low > 0.0; }
  /// "helps", "harms" or "cannot tell".
  std::string_view in_words() const;
};

/// Compares two models' predictions from the same starts. The interval is that of resampled blocks of
/// thresholds::rollout_block starts, widened as their number asks for; where these are fewer than
/// thresholds::fewest_rollout_blocks, of blocks of thresholds::short_rollout_block; where these are fewer, too, there
/// is none.
ErrorChange compare(const StartErrors& with, const StartErrors& without);

}  // namespace gripline::diagnose
