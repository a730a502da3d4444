// gripline compare on the race of the fixtures, in a folder that goes with the test.
#pragma once

#include <gtest/gtest.h>

#include "support/program.hpp"

namespace gripline::testing_support {

class RaceProgram : public testing::Test {
 protected:
  Outcome compare(std::vector<std::string> words, const Call& call = {}) const {
    words.insert(words.begin(), {"compare", "experiments/good.json"});
    return gripline_with(words, call);
  }
  std::string out(const std::string& name = "out") const { return folder_ / name; }
  Folder folder_;
};

}  // namespace gripline::testing_support
