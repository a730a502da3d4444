#include "report/plot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace gripline::report {
namespace test_report_plot {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

TEST(ReportPlot, TicksAreRound) {
  EXPECT_THAT(round_ticks(0, 10, 5), ElementsAre(0, 2, 4, 6, 8, 10));
  EXPECT_THAT(round_ticks(-0.11, 0.2, 3),
              ElementsAre(testing::DoubleNear(-0.1, 1e-12), testing::DoubleNear(0, 1e-12),
                          testing::DoubleNear(0.1, 1e-12), testing::DoubleNear(0.2, 1e-12)));
  EXPECT_THAT(round_ticks(1, 1, 5), ElementsAre(1));
  EXPECT_LE(round_ticks(1e9, 1e9 + 2e-7, 12).size(), 40u);  // steps below the rounding of the numbers
}

TEST(ReportPlot, TextIsEscapedAndEmptyPanelsAreDrawn) {
  Panel panel;
  panel.title = "<a> & \"b\"";
  const std::string svg = draw_panels("</svg>", {panel}, 2, 300, 200);
  EXPECT_THAT(svg, HasSubstr("&lt;a&gt; &amp; &quot;b&quot;"));
  EXPECT_THAT(svg, HasSubstr("&lt;/svg&gt;"));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
}

}  // namespace test_report_plot
}  // namespace gripline::report
