#include "limit/lap_mesh.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <vector>

#include "support/sample_curves.hpp"

namespace gripline {
namespace test_lap_mesh {

constexpr double pi = std::numbers::pi;

/// Two straights of 4 m and two half circles of 1 m to the left; wider on the left.
Track stadium_road() {
  return Track(TrackShape{.centre = test::stadium(), .half_width_right = 0.3, .half_width_left = 0.5});
}
/// Unequal intervals: two on the first straight, two on each bend, one on the second straight.
const std::vector<double> stations{0.0, 1.0, 4.0, 4.0 + 0.5 * pi, 4.0 + pi, 8.0 + pi, 8.0 + 1.5 * pi};

TEST(LapMesh, IntervalsCloseTheLap) {
  const Track track = stadium_road();
  const LapMesh mesh = make_mesh(track, stations);
  ASSERT_EQ(mesh.size(), stations.size());
  double sum = 0.0;
  for (const double ds : mesh.ds) sum += ds;
  EXPECT_NEAR(sum, track.length(), 1e-9);
  EXPECT_NEAR(mesh.ds[1], 3.0, 1e-12);
  EXPECT_NEAR(mesh.ds.back(), 0.5 * pi, 1e-9);  // back to the first node
}

TEST(LapMesh, CurvatureIsTheMeanOfAnInterval) {
  const LapMesh mesh = make_mesh(stadium_road(), stations);
  for (const std::size_t straight : {0u, 1u, 4u}) EXPECT_NEAR(mesh.kappa[straight], 0.0, 1e-9);
  for (const std::size_t bend : {2u, 3u, 5u, 6u}) EXPECT_NEAR(mesh.kappa[bend], 1.0, 1e-9) << bend;
  // Half on the straight, half in the bend.
  EXPECT_NEAR(make_mesh(stadium_road(), {3.5, 4.5}).kappa[0], 0.5, 1e-9);
}

TEST(LapMesh, EdgesAndPlacesAreWhereTheyAreSaidToBe) {
  TrackShape shape{.centre = test::stadium(), .half_width_right = 0.3, .half_width_left = 0.5};
  shape.half_width_left = StationTable(shape.centre.length(), {0.0, 1.0, 4.0}, {0.5, 0.4, 0.5});
  const LapMesh mesh = make_mesh(Track(std::move(shape)), stations);
  EXPECT_NEAR(mesh.n_hi[0], 0.5, 1e-12);
  EXPECT_NEAR(mesh.n_hi[1], 0.4, 1e-12);
  EXPECT_NEAR(mesh.mid_hi[0], 0.45, 1e-12);
  EXPECT_NEAR(mesh.n_lo[0], -0.3, 1e-12);
  EXPECT_NEAR(mesh.mid_lo[0], -0.3, 1e-12);
  EXPECT_NEAR(mesh.places[1].s, 2.5, 1e-12);
  EXPECT_NEAR(mesh.places[1].n, 0.0, 1e-12);
  EXPECT_NEAR(mesh.places[2].kappa, 1.0, 1e-9);
  EXPECT_NEAR(mesh.places[2].yaw_line, 0.25 * pi, 1e-9);
}

TEST(LapMesh, HalvingKeepsTheNodes) {
  const Track track = stadium_road();
  const LapMesh mesh = make_mesh(track, stations), finer = halved(track, mesh);
  ASSERT_EQ(finer.size(), 2 * mesh.size());
  for (std::size_t k = 0; k < mesh.size(); ++k) {
    EXPECT_EQ(finer.s[2 * k], mesh.s[k]);
    EXPECT_NEAR(finer.ds[2 * k], 0.5 * mesh.ds[k], 1e-9);
    EXPECT_NEAR(finer.ds[2 * k + 1], 0.5 * mesh.ds[k], 1e-9);
  }
}

/// States between two nodes are their mean, commands those of the interval that is halved; the last node leads back.
TEST(LapMesh, ALapIsHalvedWithItsMesh) {
  Lap lap;
  lap.z = {{0.0, 0.1, 1.0, 0.0, 0.2, 0.05, 0.3, -1.0}, {0.2, 0.3, 3.0, 0.4, 0.6, 0.15, 0.5, 2.0}};
  const Lap finer = halved(lap);
  ASSERT_EQ(finer.z.size(), 4u);
  EXPECT_EQ(finer.z[0], lap.z[0]);
  EXPECT_EQ(finer.z[2], lap.z[1]);
  for (const std::size_t between : {1u, 3u}) {
    EXPECT_NEAR(finer.z[between][lap_n], 0.1, 1e-12) << between;
    EXPECT_NEAR(finer.z[between][lap_vx], 2.0, 1e-12) << between;
    EXPECT_NEAR(finer.z[between][lap_delta], 0.1, 1e-12) << between;
    EXPECT_EQ(finer.z[between][lap_d], finer.z[between - 1][lap_d]) << between;
    EXPECT_EQ(finer.z[between][lap_rate], finer.z[between - 1][lap_rate]) << between;
  }
  EXPECT_FALSE(finer.solved);
}

}  // namespace test_lap_mesh
}  // namespace gripline
