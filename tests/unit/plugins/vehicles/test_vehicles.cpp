// What holds of every vehicle model: mirror symmetry, energy, standing, rolling backwards.
#include "support/vehicle_checks.hpp"

namespace gripline {
namespace test_vehicles {

using namespace rig;

constexpr const char* all_ids[] = {"kinematic", "ekinematic", "dynamic"};
const Settings losses = {{"Cr0", 0.0518}, {"Cd", 0.01}, {"Cb", 0.3}};

/// Seeded instants that a test of symmetry or energy must hold at: any direction, any size, many at rest or nearly so.
std::vector<Instant> wild_instants(int count, double most_throttle) {
  std::mt19937_64 random(11);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  const auto speed = [&](double most) {
    const double sizes[] = {0.0, 1e-6, 0.01, 0.05, 0.3, most};
    return uniform(-1, 1) * sizes[random() % 6];
  };
  std::vector<Instant> all;
  for (int i = 0; i < count; ++i)
    all.push_back({speed(4), speed(4), speed(20), uniform(-1, most_throttle), uniform(-0.6, 0.6), uniform(-5, 5)});
  return all;
}

/// Puts the velocities of a car without slip where its wheels point.
Instant rolling_where_wheels_point(const std::string& id, Instant at, const Car& car) {
  const double L = car.lf + car.lr, turn = id == "kinematic" ? std::tan(at[4]) : at[4];
  at[1] = at[0] * car.lr / L * turn;
  at[2] = at[0] * turn / L;
  return at;
}

TEST(Vehicles, MirroredCarsMoveMirrored) {
  for (const char* id : all_ids) {
    const TestedModel tested(id, losses);
    Place place, mirrored;
    place.grade = mirrored.grade = 0.04;
    place.bank = 0.05;
    mirrored.bank = -0.05;
    for (const Instant& at : wild_instants(2000, 1.0)) {
      const auto [vx, vy, omega, d, delta, rate] = at;
      const Quantities<double> q = tested.at(at, place);
      const Quantities<double> m = tested.at({vx, -vy, -omega, d, -delta, -rate}, mirrored);
      const auto expect = [&](double one, double other, const char* what) {
        EXPECT_NEAR(one, other, 1e-12 * (1 + std::abs(one))) << id << ' ' << what << " at " << vx << ' ' << vy;
      };
      expect(q.ax, m.ax, "ax");
      expect(q.ay, -m.ay, "ay");
      expect(q.aw, -m.aw, "aw");
      expect(q.bank, -m.bank, "bank");
      expect(q.drive_force, m.drive_force, "drive force");
    }
  }
}

/// Without drive, on level ground, kinetic energy never grows: m (vx vx' + vy vy') + Iz omega omega' <= 0. Of cars
/// without slip it is asked where they can be: rolling where the wheels point, and these held.
TEST(Vehicles, TyresResistanceAndBrakesNeverAddEnergy) {
  for (const char* id : all_ids) {
    const TestedModel tested(id, losses);
    for (Instant at : wild_instants(5000, 0.0)) {
      at[5] = 0;
      if (std::string(id) != "dynamic") at = rolling_where_wheels_point(id, at, small_car());
      const Quantities<double> q = tested.at(at);
      const double power = q.m * (at[0] * q.ax + at[1] * q.ay) + q.Iz * at[2] * q.aw;
      EXPECT_LE(power, 1e-15) << id << " at vx " << at[0] << ", vy " << at[1] << ", omega " << at[2] << ", d " << at[3]
                              << ", delta " << at[4];
    }
  }
}

/// Backwards everything is as forwards, seen from behind: vx' turns round.
TEST(Vehicles, BackwardsDriveTrainAndResistanceTurnRound) {
  for (const char* id : all_ids)
    for (const Settings& settings : {losses, Settings{{"Cr0", 0.0518}, {"Cd", 0.01}}}) {
      const TestedModel tested(id, settings);
      for (const double vx : {0.005, 0.02, 0.3, 4.0})
        for (const double d : {0.0, -0.1, -1.0})
          EXPECT_NEAR(tested.at({-vx, 0, 0, d, 0, 0}).ax, -tested.at({vx, 0, 0, d, 0, 0}).ax, 1e-12) << id << ' ' << vx;
    }
}

TEST(Vehicles, DerivativesAtRestAreFinite) {
  for (const char* id : all_ids) {
    const TestedModel tested(id, losses);
    for (const double d : {0.0, 0.5, -0.5})
      for (const double delta : {0.0, 0.3}) {
        std::array<Dual8, 6> at{};
        at[3] = Dual8(d), at[4] = Dual8(delta);
        for (int i = 0; i < 6; ++i) at[static_cast<std::size_t>(i)].d[i] = 1.0;
        const std::vector<Dual8> params(tested.params.begin(), tested.params.end());
        const Quantities<Dual8> q = evaluate(*tested.model, at, params);
        for (const Dual8& rate : {q.ax, q.ay, q.aw}) {
          EXPECT_TRUE(std::isfinite(rate.v));
          for (const double one : rate.d) EXPECT_TRUE(std::isfinite(one)) << id << ' ' << d << ' ' << delta;
        }
        if (d < 0 && delta == 0) {
          EXPECT_NEAR(q.ax.d[0], -40 - 0.0518 / 0.02 / 0.041, 1e-9) << id;  // 0.15 N / (m slow) is more than 40 / s
        }
      }
  }
}

TEST(Vehicles, RatesAreContinuousThroughStandstill) {
  for (const char* id : all_ids) {
    const TestedModel tested(id, losses);
    Place place;
    place.grade = 0.05;
    for (Instant at : {Instant{0, 0.01, 0.2, -0.7, 0.3, 0}, Instant{0, 0, 0, -0.01, -0.2, 1}})
      for (int i = -600; i <= 600; ++i) {
        const double vx = 0.0005 * i;  // where pieces of the forces meet too: a sample on either side
        at[0] = vx - 1e-9;
        const Quantities<double> a = tested.at(at, place);
        at[0] = vx + 1e-9;
        const Quantities<double> b = tested.at(at, place);
        EXPECT_NEAR(a.ax, b.ax, 2e-5) << id << ' ' << vx;
        EXPECT_NEAR(a.ay, b.ay, 2e-5) << id << ' ' << vx;
        EXPECT_NEAR(a.aw, b.aw, 2e-3) << id << ' ' << vx;
      }
  }
}

/// Steps of a car by itself under one command.
class HeldCommand {
 public:
  HeldCommand(const char* id, const Settings& settings, const char* tableau, int substeps = 1)
      : nominal_(id, settings), model_(nominal_.car(), Nominal::options(tableau, substeps)) {}
  State after(State x, double d, const Place& place, int steps) {
    model_.reset(x, d, place);
    for (int i = 0; i < steps; ++i) x = model_.advance(x, {d, 0}, place);
    return x;
  }

 private:
  Nominal nominal_;
  CorrectedModel model_;
};

State moving(double vx, double delta = 0) {
  State x;
  x.vx = vx;
  x.delta = delta;
  return x;
}

TEST(Vehicles, BrakedCarsComeToRestAndStayThere) {
  for (const char* id : all_ids)
    for (const char* tableau : {"rk4", "rk6"})
      for (const double grade : {0.0, 0.08, -0.08})
        for (const double vx : {2.0, 0.0, -2.0}) {
          Place place;
          place.grade = grade;
          HeldCommand drive(id, losses, tableau);
          const State stopped = drive.after(moving(vx), -1, place, 150);
          EXPECT_NEAR(stopped.vx, 0.0, 1e-12) << id << ' ' << tableau << ' ' << grade << ' ' << vx;
          const State later = drive.after(stopped, -1, place, 500);
          EXPECT_NEAR(later.x, stopped.x, 1e-12) << id << ' ' << tableau << ' ' << grade << ' ' << vx;
        }
}

/// v dv = -(B + Cr0 + Cd v^2) / m ds, backwards as forwards; below B / (40 m) the brakes come off by and by, which
/// takes a hundredth of the way more.
TEST(Vehicles, BrakingDistanceBackwards) {
  for (const char* id : all_ids)
    for (const double vx : {2.0, -2.0}) {
      const State stopped = HeldCommand(id, losses, "rk4", 20).after(moving(vx), -1, {}, 150);
      const double force = 0.3 + 0.0518, distance = 0.041 / (2 * 0.01) * std::log(1 + 0.01 * vx * vx / force);
      EXPECT_NEAR(std::abs(stopped.x), distance, 0.01 * distance) << id;
      EXPECT_GT(stopped.x * vx, 0.0);
    }
}

TEST(Vehicles, SteeredCarsThatBrakesHoldOnASlopeDoNotTurn) {
  Place place;
  place.grade = 0.08;
  for (const char* id : all_ids) {
    const State x = HeldCommand(id, losses, "rk4", 16).after(moving(0, 0.3), -1, place, 500);
    EXPECT_NEAR(std::hypot(x.x, x.y), 0.0, 2e-4) << id;
    EXPECT_NEAR(x.yaw, 0.0, 1e-9) << id;
    EXPECT_NEAR(std::hypot(x.vx, x.vy), 0.0, 5e-5) << id;
  }
}

/// On a bank each axle holds its share of m g sin(bank) by slip, velocity across over 0.02 m/s: a third of a mm/s.
TEST(Vehicles, ATyredCarOnABankCreepsByItsSlipOnly) {
  Place place;
  place.bank = 0.05;
  const Settings settings = {{"Cr0", 0.0518}, {"Cb", 0.3}};
  const State x = HeldCommand("dynamic", settings, "rk4", 128).after(moving(0), -1, place, 100);
  namespace car = conformance::published;
  const double L = 0.029 + 0.033, way = 0.02 * 0.041 * gravity * std::sin(0.05);
  const double front = way * (0.033 / L) / (car::Bf * car::Cf * car::Df);
  const double rear = way * (0.029 / L) / (car::Br * car::Cr * car::Dr);
  const double expected = (0.033 * front + 0.029 * rear) / L;
  EXPECT_NEAR(x.vy, expected, 0.02 * expected);
}

/// The front tyres push to the side that the wheels point to, seen along the motion: omega = vx tan(delta) / L.
TEST(Dynamic, ReversingItTurnsWhereItsWheelsPoint) {
  const Car car = small_car();
  for (const double vx : {0.5, -0.5}) {
    Nominal nominal("dynamic", {{"Cm1", 0}, {"Cm2", 0}});
    CorrectedModel model(nominal.car(), Nominal::options("rk4", 32));
    State x = moving(vx, 0.05);
    model.reset(x, 0, {});
    for (int i = 0; i < 10; ++i) x = model.advance(x, {0, 0}, {});
    EXPECT_NEAR(x.omega, x.vx * std::tan(0.05) / (car.lf + car.lr), 0.1 * std::abs(x.omega)) << vx;
  }
}

/// Without friction no tyre pushes, with hardly any hardly any does.
TEST(Dynamic, FrictionBoundsTheForcesOfItsAxles) {
  for (const double mu : {0.0, 1e-12, 0.3}) {
    const TestedModel tested("dynamic", {{"Df", 0.21 * mu}, {"Dr", 0.19 * mu}});
    for (const Instant& at : wild_instants(500, 1.0)) {
      const Quantities<double> q = tested.at(at);
      EXPECT_LE(std::abs(q.force_front), 0.21 * mu);
      EXPECT_LE(std::abs(q.force_rear), 0.19 * mu);
    }
  }
}

}  // namespace test_vehicles
}  // namespace gripline
