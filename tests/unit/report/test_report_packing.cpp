#include "report/packing.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "report/columns.hpp"
#include "support/report_files.hpp"

namespace gripline::report {
namespace test_report_packing {

using testing::HasSubstr;
using testing::Not;

TEST(ReportPacking, Base64) {
  const auto encode = [](std::string_view text) {
    return base64({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  };
  EXPECT_EQ(encode(""), "");
  EXPECT_EQ(encode("f"), "Zg==");
  EXPECT_EQ(encode("fo"), "Zm8=");
  EXPECT_EQ(encode("foobar"), "Zm9vYmFy");  // RFC 4648, section 10
}

TEST(ReportPacking, ColumnsComeBackWithinTheirPrecision) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> value(-3, 5);
  std::vector<double> values(500);
  for (double& v : values) v = 5e6 + value(random);  // far from the origin, as in map coordinates
  values[17] = gap;
  const std::vector<double> single = unpacked(pack(values, Precision::single));
  const std::vector<double> half = unpacked(pack(values, Precision::half));
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i == 17) {
      EXPECT_TRUE(std::isnan(single[i]) && std::isnan(half[i]));
      continue;
    }
    EXPECT_NEAR(single[i], values[i], 1e-6);
    EXPECT_NEAR(half[i], values[i], 8.0 / 65534);
  }
}

TEST(ReportPacking, ConstantsAndEvenStepsCostNothing) {
  EXPECT_EQ(pack(std::vector<double>(100, 0.7), Precision::half)["k"], "c");
  std::vector<double> t(100);
  for (std::size_t i = 0; i < t.size(); ++i) t[i] = 0.02 * static_cast<double>(i);
  const nlohmann::json packed = pack(t, Precision::half);
  EXPECT_EQ(packed["k"], "u");
  EXPECT_NEAR(unpacked(packed)[99], 1.98, 1e-12);
}

TEST(ReportPacking, WhatNoAxisHoldsIsAGap) {
  const std::vector<double> values{1, 1e308, -1e308, std::numeric_limits<double>::infinity(), 2, gap};
  for (const Precision precision : {Precision::single, Precision::half}) {
    const std::vector<double> back = unpacked(pack(values, precision));
    EXPECT_NEAR(back[0], 1, 1e-4);
    EXPECT_NEAR(back[4], 2, 1e-4);
    for (const std::size_t i : {1u, 2u, 3u, 5u}) EXPECT_TRUE(std::isnan(back[i]));
  }
  EXPECT_TRUE(std::isnan(unpacked(pack(std::vector<double>{gap, 1e300}, Precision::single))[0]));
}

TEST(ReportPacking, JsonCannotEndItsScript) {
  const nlohmann::json nasty = {{"</script><script>alert(1)</script>", "<!-- \" ' & \xc3\xbc \xff"}};
  const std::string text = script_safe(nasty);
  EXPECT_THAT(text, Not(HasSubstr("<")));
  EXPECT_EQ(nlohmann::json::parse(text).begin().key(), "</script><script>alert(1)</script>");
  EXPECT_EQ(html_escaped("<a b='\"&'>"), "&lt;a b=&#39;&quot;&amp;&#39;&gt;");
}

}  // namespace test_report_packing
}  // namespace gripline::report
