#include "exports/wide_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace gripline::exports {
namespace test_wide_csv {

using report::Columns;

TEST(WideCsv, RowsOfOneInstantAreOneLine) {
  const std::vector<NamedRun> runs = {{"elm", Columns::parse("t_s,vx_mps,lap\n0,1,0\n0.02,2,0\n0.04,3,1\n")},
                                      {"best", Columns::parse("t_s,vx_mps\n0,5\n0.0200000001,6\n")}};
  EXPECT_EQ(wide_csv(runs),
            "t_s,elm/vx_mps,elm/lap,best/vx_mps\n"
            "0,1,0,5\n"
            "0.02,2,0,6\n"
            "0.04,3,1,\n");
}

TEST(WideCsv, RatesMayDiffer) {
  const std::vector<NamedRun> runs = {{"a", Columns::parse("t_s,x\n0,1\n0.01,2\n0.02,3\n")},
                                      {"b, c", Columns::parse("t_s,x\n0.015,7\n")}};
  EXPECT_EQ(wide_csv(runs),
            "t_s,a/x,\"b, c/x\"\n"
            "0,1,\n"
            "0.01,2,\n"
            "0.015,,7\n"
            "0.02,3,\n");
}

}  // namespace test_wide_csv
}  // namespace gripline::exports
