#include "sweep/store.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/sweep_rig.hpp"

namespace gripline::sweep {
namespace test_store {

using namespace testing_support;

class Stores : public SweepRig {};

TEST_F(Stores, ASecondRunOfTheSameSweepComputesNothingAndALargerOneOnlyWhatIsNew) {
  factors({"/base/planner/params/mu=0.3,0.4"});
  const Sweep sweep = planned();
  body(sweep)(*missing("out", 100), 0, [] {});
  EXPECT_EQ(runs_, 4);
  planned();
  EXPECT_FALSE(missing("out", 100));
  factors({"/base/planner/params/mu=0.4,0.45,0.3"});
  const Sweep larger = planned();
  EXPECT_EQ(missing("out", 100)->runs, 2u);
  body(larger)(*missing("out", 100), 0, [] {});
  EXPECT_EQ(runs_, 6);
}

TEST_F(Stores, KeepWhatARunDidAndReadRecordsWithoutIt) {
  const Store store(out());
  Record record;
  record.key = std::string(64, 'a');
  record.status = "finished";
  store.write(record);
  EXPECT_THAT(contents(out() / "results/aa" / (record.key + ".json")), testing::Not(testing::HasSubstr("drive")));
  EXPECT_EQ(store.read(record.key).value().drive, "");
  record.drive = std::string(64, 'd');
  store.write(record);
  EXPECT_EQ(store.read(record.key).value().drive, record.drive);
}

TEST_F(Stores, KeepWhyARunIsMissingUntilItIsThere) {
  const Store store(out());
  Record record;
  record.key = std::string(64, 'b');
  record.status = "finished";
  EXPECT_EQ(store.why_missing(record.key), "");
  store.note_missing(record.key, "was ended by signal 9 (Killed)");
  EXPECT_EQ(store.why_missing(record.key), "was ended by signal 9 (Killed)");
  EXPECT_FALSE(store.has(record.key, true));
  store.write(record);
  EXPECT_EQ(store.why_missing(record.key), "");
}

}  // namespace test_store
}  // namespace gripline::sweep
