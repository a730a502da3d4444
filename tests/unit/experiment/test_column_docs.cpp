#include "experiment/column_docs.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "experiment/claims.hpp"
#include "support/host_support.hpp"
#include "support/paths.hpp"

namespace gripline {
namespace test_column_docs {

using namespace testing_support;

TEST(ColumnDocs, ThePageIsWhatTheProgramPrints) {
  EXPECT_EQ(contents(source_dir() / "framework/doc/columns.md"), columns_page())
      << "gripline columns --markdown > framework/doc/columns.md";
}

TEST(ColumnDocs, NumbersInNamesAreAnyNumber) {
  EXPECT_EQ(documented_name("lap12_s"), "lapK_s");
  EXPECT_EQ(documented_name("lap0_mean_factor"), "lapK_mean_factor");
  EXPECT_EQ(documented_name("pace_ratio3"), "pace_ratioK");
  EXPECT_EQ(documented_name("body_pace_ratio3"), "body_pace_ratioK");
  EXPECT_EQ(documented_name("lap0_s_lo"), "COLUMN_lo");
  EXPECT_EQ(documented_name("plan9_y_m"), "planK_y_m");
  EXPECT_EQ(documented_name("lap"), "lap");
  EXPECT_EQ(documented_name("lo"), "lo");
}

TEST(ColumnDocs, EveryColumnIsExplainedOnce) {
  const std::vector<std::string> files = documented_files();
  ASSERT_FALSE(files.empty());
  for (const std::string& file : files) {
    std::set<std::string> names;
    for (const ColumnDoc* column : columns_of(file)) {
      EXPECT_TRUE(names.insert(column->name).second) << file << " " << column->name;
      EXPECT_NE(*column->meaning, '\0') << column->name;
    }
    EXPECT_GE(names.size(), 3u) << file;
  }
}

}  // namespace test_column_docs
}  // namespace gripline
