#include "bags/bag_guess.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "bags/bag_table.hpp"
#include "config/errors.hpp"
#include "measured/session/session_checks.hpp"
#include "measured/session/session_file.hpp"
#include "support/bag_writing.hpp"
#include "support/scratch.hpp"

namespace gripline::bags {
namespace test_bag_guess {

using testing::Contains;
using testing::HasSubstr;
using testing_support::MemoryBag;
using testing_support::MessageBytes;
using testing_support::Weaving;

TEST(BagGuess, ItsMapReadsTheBagItWasMadeFrom) {
  for (const Wire wire : {Wire::ros1, Wire::cdr}) {
    testing_support::Recording all = testing_support::weaving_recording(wire, 40.0, wire == Wire::ros1);
    const auto camera = all.topic("/camera", "my_msgs/Picture", wire == Wire::ros1 ? "uint8[] pixels\n" : "");
    for (std::int64_t k = 0; k < 3000; ++k) all.add(camera, testing_support::weaving_start + 1'000'000 * k, {});
    MemoryBag bag(std::move(all));
    const measured::Guess guess = guess_map(bag);
    const auto file = testing_support::scratch("guess.json");
    std::ofstream(file) << to_json_text(guess.map);
    const measured::LogMap map = measured::load_log_map(file);
    EXPECT_EQ(map.bag.rows, "/odom") << "readings at their own times";
    const measured::SessionFile session = measured::read_session(read_table(bag, map), map);
    check_session(session, 10.0);
    const measured::Session& s = session.session;
    EXPECT_NEAR(s.t[100], 5.0, 1e-9);
    EXPECT_NEAR(s.at(100, 5), Weaving::rate(5.0), 1e-9);
    EXPECT_NEAR(s.command[100].delta, Weaving::steer(5.0), 1e-7);
    EXPECT_NEAR(s.command[100].d, Weaving::throttle(5.0), 1e-5);
    EXPECT_FALSE(map.delay(0).has_value()) << "to be found";
    EXPECT_THAT(guess.remarks, Contains(HasSubstr("bag: /odom: 801 messages at 20 Hz")));
    EXPECT_EQ(std::count(guess.remarks.begin(), guess.remarks.end(),
                         "bag: /camera (my_msgs/Picture): its type is not defined"),
              wire == Wire::cdr);
  }
}

TEST(BagGuess, TopicsWhoseNamesEndAlikeAreToldApart) {
  testing_support::Recording all = testing_support::weaving_recording(Wire::ros1);
  all.topics[0].name = "/vehicle/odom";
  const auto busier = all.topic("/odom", "car_msgs/Battery", "float64 volt\n");
  for (std::int64_t k = 0; k < 3000; ++k)
    all.add(busier, testing_support::weaving_start + 1'000'000 * k, MessageBytes(Wire::ros1).add(12.0).bytes());
  MemoryBag bag(std::move(all));
  const measured::Guess guess = guess_map(bag);
  EXPECT_THAT(to_json_text(guess.map), HasSubstr("\"rows\": \"/vehicle/odom\""));
}

TEST(BagGuess, OwnTypesAreTakenByTheirNames) {
  testing_support::Recording all;
  const auto car =
      all.topic("/car/state", "my_msgs/State", "float64 yaw_rate\nfloat64 vehicle_speed\nfloat64 steering_angle\n");
  for (std::int64_t k = 0; k < 500; ++k) {
    const double t = 0.05 * static_cast<double>(k);
    all.add(car, std::llround(1e9 * t),
            MessageBytes(Wire::ros1).add(Weaving::rate(t)).add(10.0).add(-Weaving::steer(t)).bytes());
  }
  MemoryBag bag(std::move(all));
  const measured::Guess guess = guess_map(bag);
  const std::string text = to_json_text(guess.map);
  EXPECT_THAT(text, HasSubstr("/car/state.vehicle_speed"));
  EXPECT_THAT(text, HasSubstr("/car/state.yaw_rate"));
  EXPECT_THAT(guess.remarks, Contains(HasSubstr("positive to the right")));
}

TEST(BagGuess, ABagWithoutACarSaysWhatItHolds) {
  testing_support::Recording all;
  const auto talk = all.topic("/chatter", "std_msgs/String", "string data\n");
  all.add(talk, 1, MessageBytes(Wire::ros1).text("hello").bytes());
  MemoryBag bag(std::move(all));
  try {
    guess_map(bag);
    FAIL();
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(),
                HasSubstr("no topic looks like a motion or a command of a car; found /chatter (std_msgs/String)"));
  }
}

}  // namespace test_bag_guess
}  // namespace gripline::bags
