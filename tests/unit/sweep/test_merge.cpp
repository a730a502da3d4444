#include "sweep/merge.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/sweep_rig.hpp"

namespace gripline::sweep {
namespace test_merge {

namespace fs = std::filesystem;
using namespace testing_support;
using testing::HasSubstr;

class Merge : public SweepRig {};

TEST_F(Merge, MissingRunsAreNamedAndDamagedRecordsAreMissing) {
  factors({"/base/planner/params/mu=0.3,0.4"});
  const Sweep sweep = planned();
  const std::optional<Batch> first = missing("out", 2);
  body(sweep)(*first, 0, [] {});
  EXPECT_EQ(runs_, 2);
  Table table;
  MergeOutcome outcome = merge_records(out(), sweep, table);
  EXPECT_EQ(outcome.missing, 2u);
  EXPECT_THAT(lines(out() / "missing.csv").back(), HasSubstr("3,small,1,fast,1,missing,"));
  const std::string key = KeyFile(out(), sweep).key(0);
  const fs::path record = out() / "results" / key.substr(0, 2) / (key + ".json");
  ASSERT_TRUE(fs::exists(record));
  for (const std::string& damaged : {std::string(), contents(record).substr(0, 100), contents(record) + "x"}) {
    write_text(record, damaged);
    Table again;
    EXPECT_EQ(merge_records(out(), sweep, again).missing, 3u);
    EXPECT_FALSE(fs::exists(record));
  }
  const std::optional<Batch> rest = missing("out", 10);
  EXPECT_EQ(rest->runs, 3u);
  body(sweep)(*rest, 0, [] {});
  Table whole;
  EXPECT_TRUE(merge_records(out(), sweep, whole).complete());
}

}  // namespace test_merge
}  // namespace gripline::sweep
