#include "report/series.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <gripline/types.hpp>

#include "report/columns.hpp"
#include "report/inputs.hpp"

namespace gripline::report {
namespace test_report_series {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(ReportSeries, ThinningKeepsEveryExtreme) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 1);
  std::vector<double> values(10007);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = std::sin(0.001 * static_cast<double>(i)) + 0.01 * noise(random);
  values[4321] = 9;  // one step wide
  values[7777] = -9;
  for (const std::size_t stride : {2u, 5u, 16u}) {
    const std::vector<double> kept = thin(values, Thinning::extremes, stride);
    EXPECT_NEAR(static_cast<double>(kept.size()), 10007.0 / static_cast<double>(stride), 2.0);
    EXPECT_EQ(*std::max_element(kept.begin(), kept.end()), 9);
    EXPECT_EQ(*std::min_element(kept.begin(), kept.end()), -9);
    // The envelope of every bucket is that of the full data.
    for (std::size_t bucket = 0; (bucket + 1) * 2 * stride + stride < values.size(); ++bucket) {
      const auto from = values.begin() + static_cast<long>(bucket * 2 * stride);
      const auto [low, high] = std::minmax_element(from, from + static_cast<long>(2 * stride));
      EXPECT_EQ(std::min(kept[2 * bucket], kept[2 * bucket + 1]), *low);
      EXPECT_EQ(std::max(kept[2 * bucket], kept[2 * bucket + 1]), *high);
    }
  }
}

/// What falls or rises to the end of the log has its extreme in the last row, however many rows remain there.
TEST(ReportSeries, ThinningKeepsTheEnds) {
  for (std::size_t stride = 2; stride < 6; ++stride)
    for (std::size_t n = stride + 1; n < 50; ++n)
      for (const double sign : {1.0, -1.0}) {
        std::vector<double> values(n);
        for (std::size_t i = 0; i < n; ++i) values[i] = sign * static_cast<double>(i * i);
        const std::vector<double> kept = thin(values, Thinning::extremes, stride);
        EXPECT_EQ(*std::min_element(kept.begin(), kept.end()), *std::min_element(values.begin(), values.end())) << n;
        EXPECT_EQ(*std::max_element(kept.begin(), kept.end()), *std::max_element(values.begin(), values.end())) << n;
      }
}

TEST(ReportSeries, ThinningSharesItsPlacesAmongChannels) {
  for (std::size_t n = 1; n < 40; ++n)
    for (std::size_t stride = 1; stride < 6; ++stride) {
      std::vector<double> values(n);
      for (std::size_t i = 0; i < n; ++i) values[i] = static_cast<double>(i);
      const std::vector<double> times = thin(values, Thinning::sample, stride);
      EXPECT_EQ(times.size(), thin(values, Thinning::extremes, stride).size()) << n << " " << stride;
      EXPECT_EQ(times.size(), thin(values, Thinning::any, stride).size());
      for (std::size_t i = 1; i < times.size(); ++i) EXPECT_EQ(times[i] - times[i - 1], static_cast<double>(stride));
    }
  EXPECT_THAT(thin(std::vector<double>{0, 0, 1, 0, 0, 0, 0, 0}, Thinning::any, 2), ElementsAre(0, 1, 0, 0));
}

TEST(ReportSeries, DerivesAccelerationsAndFrictionOfTheWholeCar) {
  // A steady circle: speed 2, yaw rate 0.5 and no lateral speed give 1 m/s2 to the left and nothing along.
  std::string text = "t_s,vx_mps,vy_mps,yaw_rate_radps,mu_belief_front,mu_belief_rear\n";
  for (int i = 0; i < 10; ++i) text += std::to_string(0.02 * i) + ",2,0,0.5,0.8,1.0\n";
  const report::Run run{Columns::parse(text), {}, {}, {}};
  std::map<std::string, std::vector<double>> channels;
  for (TimeSeries& channel : step_channels(run, {0.06, 0.03, 0.03, 0.01, 0.04}))
    channels[channel.name] = channel.values;
  EXPECT_NEAR(channels["ax"][5], 0, 1e-12);
  EXPECT_NEAR(channels["ay"][5], 1, 1e-12);
  EXPECT_NEAR(channels["mu_belief"][0], 0.25 * 0.8 + 0.75 * 1.0, 1e-12);
}

TEST(ReportSeries, TheDeviationOfTheBeliefIsWeightedAsTheBelief) {
  const CarShape car{0.06, 0.03, 0.03, 0.01, 0.04};
  const Belief belief{0.8, 1.0, 0.04, 0.12, false};
  Car geometry;
  geometry.lf = car.lf, geometry.lr = car.lr;
  const report::Run run{{}, Columns::parse("t_s,mu_sigma_front,mu_sigma_rear\n0,0.04,0.12\n0.1,0.2,0.2\n"), {}, {}};
  const std::vector<double> sigma = mu_sigma(run, car);
  ASSERT_EQ(sigma.size(), 2u);
  EXPECT_NEAR(sigma[0], total_sigma(belief, geometry), 1e-15);
  EXPECT_NEAR(sigma[1], 0.2, 1e-15);
  EXPECT_THAT(mu_sigma({{}, Columns::parse("t_s,mu_sigma_front\n0,0.04\n"), {}, {}}, car), IsEmpty());
}

}  // namespace test_report_series
}  // namespace gripline::report
