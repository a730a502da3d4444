// What the tests of both validations share: a lap of the small oval, scores by channel.
#pragma once

#include <map>

#include "experiment/validation_files.hpp"
#include "support/host_support.hpp"

namespace gripline::testing_support {

/// One lap of the small oval at about 1.5 m/s.
inline Node lap_world(std::string_view patch = "{}") {
  const Node lap = json(R"({"duration": null, "laps": 1, "timeout": "30 s", "start": {"speed": 1}})");
  return merge(merge(small_world(), lap), json(patch));
}

using Scores = std::map<std::string, ChannelScore>;
inline Scores by_channel(const std::vector<ChannelScore>& all, const std::string& estimator) {
  Scores scores;
  for (const ChannelScore& one : all)
    if (one.estimator == estimator) scores[one.channel] = one;
  return scores;
}

}  // namespace gripline::testing_support
