// From a logger's file to a model that predicts the next session, as users do it: import, fit, predict.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <sstream>

#include "support/calibrate_rig.hpp"
#include "support/program.hpp"
#include "support/reference_data.hpp"
#include "tables/delimited_table.hpp"

namespace gripline {
namespace test_real_cars {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using namespace testing_support;
namespace fs = std::filesystem;
using measured::channels;
using measured::Session;
using test::small_car_world;

constexpr const char* unknowns = R"({"unknowns": {
  "/plant/params/Bf": {"group": "tyres", "sigma": 0.5, "scale": "log"},
  "/plant/params/Br": {"group": "tyres", "sigma": 0.5, "scale": "log"},
  "/plant/params/Df": {"group": "tyres", "sigma": 0.5, "scale": "log"},
  "/plant/params/Dr": {"group": "tyres", "sigma": 0.5, "scale": "log"},
  "/plant/params/Cm1": {"group": "drive", "sigma": 0.5, "scale": "log"},
  "/plant/effects/steer_offset/params/d0": {"group": "steer", "sigma": "20 mrad"}}})";

/// Root mean square of a prediction's error in x and y against a table with columns of the same names.
double position_error(const DelimitedTable& samples, const Session& truth) {
  double sum = 0.0, count = 0.0;
  const auto& t = samples.column[1];
  for (std::size_t i = 0; i < samples.rows(); ++i)
    for (const std::size_t c : {0u, 1u}) {
      const double off = samples.column[2 + c][i] - truth.interpolate(c, t[i]);
      if (std::isfinite(off)) sum += off * off, count += 0.5;
    }
  return std::sqrt(sum / count);
}

class RealCars : public testing::Test {
 protected:
  RealCars() {
    std::ofstream(world()) << to_json_text(merge(small_car_world(), json(unknowns)));
    std::ofstream(map()) << R"({"time": "t", "channels": {"x": {"column": "east", "delay": "find"},
      "y": {"column": "north", "delay": "find"}, "yaw": {"column": "heading", "unit": "deg", "delay": "find"},
      "vx": {"column": "speed", "unit": "km/h", "delay": "find"}, "vy": {"column": "side", "delay": "find"},
      "yaw_rate": {"column": "gyro", "delay": "find"}, "d": {"formula": "gas / 100", "kind": "command"},
      "delta": {"column": "steering", "kind": "command"}}})";
  }
  std::string world() const { return folder_ / "world.json"; }
  std::string map() const { return folder_ / "map.json"; }
  std::string in(const std::string& name) const { return folder_ / name; }

  /// A log of a car that differs from the world's by `patch`, in columns of its own.
  Session drive(const std::string& name, const std::string& patch, const test::WeavingLog& options) const {
    const test::CalibrateRig truth(small_car_world(patch));
    Session s = test::drive(truth.vehicle.car(), options);
    write(name, s);
    return s;
  }
  void write(const std::string& name, const Session& s) const {
    std::ofstream out(folder_ / name);
    out.precision(10);
    out << "t,east,north,heading,speed,side,gyro,gas,steering\n";
    for (std::size_t i = 0; i < s.rows(); ++i)
      out << s.t[i] << ',' << s.at(i, 0) << ',' << s.at(i, 1) << ',' << s.at(i, 2) * 180 / std::numbers::pi << ','
          << 3.6 * s.at(i, 3) << ',' << s.at(i, 4) << ',' << s.at(i, 5) << ',' << 100 * s.command[i].d << ','
          << s.command[i].delta << '\n';
  }
  Outcome fit(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {"fit", world()};
    words.insert(words.end(), more.begin(), more.end());
    words.insert(words.end(), {"--map", map(), "--out", in("fitted.json"), "--quiet"});
    return gripline_with(words);
  }
  DelimitedTable predict(const std::string& with, const std::string& log, const std::string& samples) const {
    const Outcome outcome = gripline_with(
        {"predict", with, log, "--map", map(), "--horizon", "1", "--every", "0.2", "--samples", in(samples)});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return read_delimited(in(samples));
  }

  static constexpr const char* another_car =
      R"({"plant": {"params": {"Bf": 6, "Dr": 7, "Cm1": 14}, "effects": [{"plugin": "steer_offset", "params": {"d0": 0.02}}]}})";
  Folder folder_;
};

TEST_F(RealCars, ALogIsImportedFittedAndTheNextOnePredicted) {
  drive("log.csv", another_car, {.seconds = 60, .noise = 1, .delay = {0, 0, 0, 0.15}});
  const Session next =
      drive("next.csv", another_car, {.seconds = 30, .noise = 1, .delay = {0, 0, 0, 0.15}, .seed = 7, .speed = 2});
  const Outcome imported = gripline_with({"import", in("log.csv"), "--map", map(), "--out", in("log.gripline.csv")});
  EXPECT_EQ(imported.code, 0) << imported.err;
  EXPECT_THAT(imported.out, AllOf(HasSubstr("50 Hz"), HasSubstr("noise of vx"), HasSubstr("against yaw"),
                                  HasSubstr("yaw_rate: 0.15 s taken off")));
  EXPECT_EQ(gripline_with({"predict", world(), in("log.gripline.csv")}).code, 0);

  const Outcome fitted = fit({in("log.csv")});
  EXPECT_EQ(fitted.code, 0) << fitted.err;
  EXPECT_THAT(fitted.out,
              AllOf(HasSubstr("friction: "), HasSubstr("in gentle corners of the logs the car understeers by "),
                    HasSubstr("; the fitted world understeers by "), HasSubstr("kinematic"), Not(HasSubstr("nan")),
                    HasSubstr("on the fitted logs themselves (in-sample)"), HasSubstr("0            rad\n")));
  EXPECT_EQ(gripline_with({"validate", in("fitted.json")}).code, 0);

  const DelimitedTable before = predict(world(), in("next.csv"), "before.csv"),
                       after = predict(in("fitted.json"), in("next.csv"), "after.csv");
  EXPECT_THAT(contents(in("after.csv")),
              testing::StartsWith("start_s,t_s,x_m,y_m,yaw_rad,vx_mps,vy_mps,yaw_rate_radps\n"));
  EXPECT_NEAR(after.column[1][5] - after.column[0][5], 1.0, 1e-9);
  EXPECT_LT(position_error(after, next), 0.3 * position_error(before, next));
  double rate = 0.0;  // as the late column shows it
  for (std::size_t i = 0; i < after.rows(); ++i)
    rate = std::max(rate, std::abs(after.column[7][i] - next.interpolate(5, after.column[1][i])));
  EXPECT_LT(rate, 0.1);
}

TEST_F(RealCars, AFitRefusesNumbersThatItCannotUse) {
  drive("log.csv", another_car, {.seconds = 20});
  for (const char* seed : {"-1", "4294967297"})
    EXPECT_THAT(fit({in("log.csv"), "--seed", seed}).err, HasSubstr("expected 0 to 4294967295"));
  for (const char* log : {"log.csv", "none.csv"})  // before logs are read
    EXPECT_THAT(fit({in(log), "--starts", "19"}).err, HasSubstr("--starts 19: expected 20 to 100000"));
}

TEST_F(RealCars, APredictionReadsNothingOfWhatFollows) {
  const Session s = drive("log.csv", another_car, {.seconds = 20, .noise = 1, .delay = {0, 0, 0, 0.15}});
  ASSERT_EQ(fit({in("log.csv"), "--fit", "drive,delays", "--starts", "40"}).code, 0);
  const DelimitedTable whole = predict(in("fitted.json"), in("log.csv"), "whole.csv");
  constexpr double last = 12.0;
  Session changed = s;
  for (std::size_t i = 0; i < s.rows(); ++i) {
    if (s.t[i] > last)
      for (std::size_t c = 0; c < channels; ++c) changed.reading[i * channels + c] = 3.0 + static_cast<double>(c);
    if (s.t[i] > last + 1.0 + 1e-9) changed.command[i] = {-1.0, 0.3};
  }
  write("changed.csv", changed);
  const DelimitedTable again = predict(in("fitted.json"), in("changed.csv"), "again.csv");
  std::size_t compared = 0;
  for (std::size_t i = 0; i < whole.rows() && whole.column[0][i] <= last; ++i, ++compared)
    for (std::size_t c = 0; c < whole.column.size(); ++c) EXPECT_EQ(again.column[c][i], whole.column[c][i]) << i;
  EXPECT_GT(compared, 50u);
}

TEST_F(RealCars, FrictionOfASlipperyFloorIsReadFromTheModelOfADryOne) {
  // Full lock and much throttle: the car slides.
  const auto sliding = [](double t) {
    return CommandSample<double>{0.45 + 0.25 * std::sin(0.5 * t), 0.3 * std::sin(1.3 * t) + 0.1 * std::sin(3.1 * t)};
  };
  drive("dry.csv", "{}", {.seconds = 60, .noise = 1, .command = sliding});
  ASSERT_EQ(fit({in("dry.csv")}).code, 0);
  const fs::path dry = in("dry.json");
  fs::rename(in("fitted.json"), dry);
  drive("wet.csv", R"({"plant": {"params": {"Df": 3, "Dr": 3}}})", {.seconds = 60, .noise = 1, .command = sliding});
  const Outcome wet = gripline_with(
      {"fit", dry.string(), in("wet.csv"), "--map", map(), "--out", in("wet.json"), "--fit", "tyres", "--quiet"});
  ASSERT_EQ(wet.code, 0) << wet.err;
  const Node fitted = parse_file(in("wet.json"));
  const double friction = find_pointer(fitted, "/calibration/friction/total")->number();
  EXPECT_NEAR(friction, 6.0 / (1.6 * 9.81), 0.03);
}

TEST_F(RealCars, AGuessedMapImportsItsLog) {
  drive("log.csv", "{}", {.seconds = 30, .noise = 1});
  const Outcome guessed = gripline_with({"import", "--guess", in("log.csv")});
  EXPECT_EQ(guessed.code, 0) << guessed.err;
  std::ofstream(in("guess.json")) << guessed.out;
  const Outcome imported = gripline_with({"import", in("log.csv"), "--map", in("guess.json"), "--out", in("own.csv")});
  EXPECT_EQ(imported.code, 0) << imported.err << guessed.out;
}

/// The mark of findings to look at is explained where one is there, and only there.
TEST_F(RealCars, AMarkInTheHealthTableIsExplained) {
  const auto table_of = [&](bool constant) {
    drive("log.csv", "{}", {.seconds = 30, .noise = 1, .command = [=](double t) {
                              CommandSample<double> command = test::weave(t);
                              if (constant) command.d = 0.4;
                              return command;
                            }});
    const Outcome imported = gripline_with({"import", in("log.csv"), "--map", map(), "--out", in("own.csv")});
    EXPECT_EQ(imported.code, 0) << imported.err;
    return imported.out;
  };
  const std::string constant = table_of(true), weaving = table_of(false);
  EXPECT_THAT(constant, AllOf(HasSubstr("d  "), HasSubstr("stays between"), HasSubstr("  (!)\n"),
                              HasSubstr("\n(!): look at this before the log is used")));
  EXPECT_EQ(weaving.find("(!): ") != std::string::npos, weaving.find("  (!)\n") != std::string::npos) << weaving;
}

/// A steering that no column's name tells: the rest of the map is written, and refused where the name is to stand.
TEST_F(RealCars, AGuessedMapLeavesOpenWhatNoNameTellsAndReplacesNoOtherUnasked) {
  drive("log.csv", "{}", {.seconds = 30, .noise = 1});
  std::string log = contents(in("log.csv"));
  std::ofstream(in("log.csv")) << log.replace(log.find("steering"), 8, "channel7");
  const Outcome guessed = gripline_with({"import", "--guess", in("log.csv"), "--out", in("guess.json")});
  EXPECT_EQ(guessed.code, 2);
  EXPECT_THAT(guessed.err, HasSubstr("no column looks like delta: fill in \"column\": \"?\""));
  std::string map = contents(in("guess.json"));
  EXPECT_THAT(map, AllOf(HasSubstr("gyro"), HasSubstr("channel7 (-0.")));
  const auto import = [&] {
    return gripline_with({"import", in("log.csv"), "--map", in("guess.json"), "--out", in("own.csv")});
  };
  const Outcome refused = import();
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err,
              AllOf(HasSubstr("/channels/delta/column"), HasSubstr("guess.json:"), HasSubstr("filled in")));
  map.replace(map.find("\"?\""), 3, "\"channel7\"");
  std::ofstream(in("guess.json")) << map;
  EXPECT_EQ(import().code, 0);
  const Outcome again = gripline_with({"import", "--guess", in("log.csv"), "--out", in("guess.json")});
  EXPECT_EQ(again.code, 2);
  EXPECT_THAT(again.err, HasSubstr("--force"));
  EXPECT_EQ(contents(in("guess.json")), map);
  EXPECT_EQ(gripline_with({"import", "--guess", in("log.csv"), "--out", in("guess.json"), "--force"}).code, 2);
  EXPECT_NE(contents(in("guess.json")), map);
}

/// Commands of a map are linear unless it says otherwise; where the world holds them, that is told.
TEST_F(RealCars, CommandsThatTheWorldHoldsAndTheMapDoesNotAreTold) {
  drive("log.csv", "{}", {.seconds = 30, .noise = 1});
  const auto told = [&](const char* world_hold, const std::string& of_map) {
    std::ofstream(world()) << to_json_text(
        merge(small_car_world(), json(std::string(R"({"input_hold": ")") + world_hold + "\"}")));
    std::string text = contents(map());
    for (std::size_t at = 0; (at = text.find("\"command\"}", at)) != std::string::npos; ++at)
      text.replace(at, 10, "\"command\"" + of_map + "}");
    std::ofstream(in("said.json")) << text;
    const Outcome outcome = gripline_with({"predict", world(), in("log.csv"), "--map", in("said.json")});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.err;
  };
  EXPECT_THAT(told("zoh", ""), HasSubstr("said.json: d and delta are read as linear between rows"));
  EXPECT_THAT(told("rate", ""), HasSubstr("said.json: d is read as linear between rows"));
  EXPECT_THAT(told("foh", ""), Not(HasSubstr("linear")));
  EXPECT_THAT(told("zoh", R"(, "hold": "sampled")"), Not(HasSubstr("linear")));
  EXPECT_THAT(told("zoh", R"(, "hold": "held")"), Not(HasSubstr("linear")));
}

/// Rows without a speed just where starts would be, and a place that no car can be at: errors are told all the same.
TEST_F(RealCars, PredictionsStartAtTheNextGoodRowAndOutliersAreNoErrors) {
  Session s = drive("log.csv", "{}", {.seconds = 30, .noise = 1});
  for (std::size_t i = 0; i < s.rows(); i += 10) s.reading[i * channels + 3] = std::nan("");
  write("gaps.csv", s);
  const auto predict = [&](const std::string& log, const std::vector<std::string>& more) {
    std::vector<std::string> words{"predict", world(), in(log), "--map", map(), "--out", in("errors.csv")};
    words.insert(words.end(), more.begin(), more.end());
    return gripline_with(words);
  };
  const Outcome gaps = predict("gaps.csv", {});
  EXPECT_EQ(gaps.code, 0) << gaps.err;
  EXPECT_THAT(gaps.out, AllOf(HasSubstr("errors at 1 s"), HasSubstr("this world")));
  const Outcome none = predict("gaps.csv", {"--slowest", "100"});
  EXPECT_EQ(none.code, 2) << none.out;
  EXPECT_THAT(none.err, HasSubstr("no start with a reading of vx of 100 m/s or more"));

  EXPECT_EQ(predict("log.csv", {}).code, 0);
  const DelimitedTable before = read_delimited(in("errors.csv"));
  s = drive("log.csv", "{}", {.seconds = 30, .noise = 1});
  s.reading[500 * channels] = 1e300;  // in the row of a start
  s.reading[757 * channels] = 1e300;  // between two
  write("far.csv", s);
  const Outcome far = predict("far.csv", {});
  EXPECT_EQ(far.code, 0) << far.err;
  EXPECT_THAT(far.err, HasSubstr("outliers: 2 readings"));
  EXPECT_THAT(far.out, Not(HasSubstr("inf")));
  const DelimitedTable after = read_delimited(in("errors.csv"));
  ASSERT_EQ(after.rows(), before.rows());
  for (std::size_t r = 0; r < after.rows(); ++r)
    EXPECT_NEAR(after.column[3][r], before.column[3][r], 0.05 * before.column[3][r]) << r;
}

/// A place that is 5 m off, in the row of a start and between two: told, and no error. Errors of slow logs count it.
TEST_F(RealCars, PlacesThatJumpThereAndBackAreNoErrors) {
  Session s = drive("log.csv", "{}", {.seconds = 30, .noise = 1});
  const auto error_of_place = [&](const std::string& log) {
    const Outcome outcome = gripline_with({"predict", world(), in(log), "--map", map(), "--out", in("errors.csv")});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const DelimitedTable errors = read_delimited(in("errors.csv"));
    return std::pair(errors.column[3].back(), outcome.err);
  };
  const double clean = error_of_place("log.csv").first;
  s.reading[500 * channels] += 5.0;
  s.reading[757 * channels + 1] -= 5.0;
  write("wild.csv", s);
  const auto [wild, told] = error_of_place("wild.csv");
  EXPECT_THAT(told, HasSubstr("outliers: 2 places that jump there and back, left out of the errors"));
  EXPECT_NEAR(wild, clean, 0.05 * clean);
  for (double& t : s.t) t *= 3.0;  // steps of 60 ms
  write("slow.csv", s);
  EXPECT_THAT(error_of_place("slow.csv").second, Not(HasSubstr("jump there and back")));
}

/// A steering offset that the world lacks: named beside `unknown`, in the world that is written. A log that is fitted
/// is refused as its own judge, one given twice used once.
TEST_F(RealCars, DiagnoseNamesWhatPredictionsOfTimeNotFittedNeed) {
  drive("log.csv", R"({"plant": {"effects": [{"plugin": "steer_offset", "params": {"d0": 0.03}}]}})",
        {.seconds = 60, .noise = 1});
  std::ofstream(world()) << to_json_text(merge(small_car_world(), json(R"({"plant": {"effects": []}, "unknowns": {
      "/plant/params/Bf": {"group": "tyres", "sigma": 0.3, "scale": "log"}}})")));
  const auto diagnose = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"diagnose", world(), in("log.csv"), "--map", map(), "--out", in("found")};
    words.insert(words.end(), more.begin(), more.end());
    return gripline_with(words);
  };
  const Outcome judged = diagnose({"--held-out", in("log.csv")});
  EXPECT_EQ(judged.code, 2);
  EXPECT_THAT(judged.err, HasSubstr("expected a log that is not"));
  EXPECT_THAT(diagnose({"--case", world()}).err, HasSubstr("--case does not go with --map"));
  fs::copy_file(in("log.csv"), in("again.csv"));
  const Outcome found = diagnose({in("again.csv")});
  EXPECT_EQ(found.code, 0) << found.err;  // something is named, though the verdict is unknown
  EXPECT_THAT(found.err, HasSubstr("used once"));
  const Node result = parse_file(in("found/diagnosis.json"));
  EXPECT_EQ(find_pointer(result, "/verdict")->text(), "unknown");
  EXPECT_THAT(find_pointer(result, "/sentence")->text(), HasSubstr("steer_offset"));
  EXPECT_THAT(contents(in("found/augmented_world.json")), HasSubstr("steer_offset"));
  // What was found leads, with how much it takes off; that the rest is unknown comes after it.
  EXPECT_THAT(found.out, AllOf(StartsWith("Calibrating the world takes "),
                               HasSubstr(" off what is left then. In gentle corners the car understeers by "),
                               HasSubstr("; the world given agrees, it understeers by "),
                               HasSubstr(" deg/g. The normalised error that remains"), HasSubstr("\n\ncalibrated "),
                               HasSubstr("\n\nverdict: unknown\n"),
                               HasSubstr("no other effect that was tried reduces it by enough")));
  EXPECT_LT(find_pointer(result, "/gap/effects/ci95/1")->number(), 0.0);
  // Nothing is wrong with its tyres, and the wrong steering offset is no understeer.
  const double gradient = find_pointer(result, "/understeer/gradient")->number();
  EXPECT_LT(find_pointer(result, "/understeer/ci95/0")->number(), gradient);
  EXPECT_NEAR(find_pointer(result, "/understeer/given")->number(), gradient, 0.1 * gradient);
  EXPECT_NEAR(find_pointer(result, "/understeer/found")->number(), gradient, 0.1 * gradient);
  // One log: what effects do to it is what they do to all.
  ASSERT_EQ(find_pointer(result, "/gap/sessions")->array().size(), 1u);
  EXPECT_EQ(find_pointer(result, "/gap/sessions/0/log")->text(), "log.csv");
  EXPECT_EQ(find_pointer(result, "/gap/sessions/0/change")->number(),
            find_pointer(result, "/gap/effects/change")->number());
  EXPECT_LT(find_pointer(result, "/gap/closure_ci95/0")->number(), find_pointer(result, "/gap/closure")->number());
  // Errors of the ranking are of one set of data; what was not fitted has none.
  const double calibrated = find_pointer(result, "/gap/judged")->number();
  std::size_t tried = 0, others = 0;
  for (const Node& row : result.find("ranking")->array()) {
    const Node& error = *row.find("held_out");
    ++(error.is_null() ? others : tried);
    if (error.is_null()) continue;
    EXPECT_NEAR(error.number() / calibrated - 1.0, find_pointer(row, "/rollout/change")->number(), 1e-6);
  }
  EXPECT_GT(tried, 0u);
  EXPECT_GT(others, 0u);
  EXPECT_THAT(found.out, AllOf(HasSubstr("d0 = 0.0"), HasSubstr(") rad\n")));
  // The page has the sentence and its log.
  EXPECT_TRUE(fs::exists(in("found/report.html"))) << found.err;
  const Node told = parse_file(in("found/diagnosis_report.json"));
  EXPECT_EQ(find_pointer(told, "/sentence")->text(), find_pointer(result, "/sentence")->text());
  EXPECT_EQ(find_pointer(told, "/log")->text(), "log.csv");
  ASSERT_FALSE(told.find("health")->array().empty());
  EXPECT_THAT(find_pointer(told, "/health/0/check")->text(), StartsWith("log.csv: "));
}

/// A log need not have everything: what is there says what is missing of the car.
TEST_F(RealCars, DiagnoseNamesAnOffsetOfTheSteeringWithoutSomeOfTheChannels) {
  drive("log.csv", R"({"plant": {"effects": [{"plugin": "steer_offset", "params": {"d0": 0.03}}]}})",
        {.seconds = 30, .noise = 1});
  std::ofstream(world()) << to_json_text(merge(small_car_world(), json(R"({"plant": {"effects": []}, "unknowns": {
      "/plant/params/Bf": {"group": "tyres", "sigma": 0.3, "scale": "log"}}})")));
  const Node all = parse_file(map());
  using Names = std::vector<const char*>;
  for (const Names& absent : {Names{"vy", "yaw_rate"}, {"x", "y", "yaw"}, {"d"}}) {
    std::string removed;
    for (const char* name : absent) removed += std::string(removed.empty() ? "" : ", ") + '"' + name + "\": null";
    const std::string less = in("less.json");
    std::ofstream(less) << to_json_text(merge(all, json(R"({"channels": {)" + removed + "}}")));
    const Outcome found =
        gripline_with({"diagnose", world(), in("log.csv"), "--map", less, "--out", in("found"), "--force"});
    EXPECT_EQ(found.code, 0) << removed << '\n' << found.err << found.out;
    EXPECT_THAT(found.out, HasSubstr("steer_offset (")) << removed;
  }
}

/// An experiment of kind "measured" and a sweep over it: the same held-out errors, one row per setting.
TEST_F(RealCars, ASweepOverMeasuredLogsHasTheNumbersOfTheExperiment) {
  drive("log.csv", another_car, {.seconds = 40, .noise = 1});
  const Node known = json(R"({"unknowns": {"/plant/params/Bf": null, "/plant/params/Br": null, "/plant/params/Df": null,
    "/plant/params/Dr": null}})");
  std::ofstream(world()) << to_json_text(merge(merge(small_car_world(), json(unknowns)), known));
  std::ofstream(in("logs.json")) << R"({"kind": "measured", "world": "world.json", "map": ")" << map()
                                 << R"(", "logs": ["log.csv"], "held_out": {"every": "10 s", "length": "4 s"},
                                    "horizon": "1 s", "every": "0.5 s"})";
  const Outcome compared = gripline_with({"compare", in("logs.json"), "--set", "/every=\"1 s\"", "--out", in("one")});
  ASSERT_EQ(compared.code, 0) << compared.err;
  const Outcome swept =
      gripline_with({"sweep", in("logs.json"), "--set", "/every=\"0.5 s\",\"1 s\"", "-j", "2", "--out", in("many")});
  ASSERT_EQ(swept.code, 0) << swept.err << contents(in("many/missing.csv"));
  const DelimitedTable table = read_delimited(in("many/table.csv"));
  ASSERT_EQ(table.rows(), 2u);
  const auto fitted = std::find(table.name.begin(), table.name.end(), "fitted.position_m");
  ASSERT_NE(fitted, table.name.end()) << contents(in("many/table.csv"));
  const double of_sweep = table.column[static_cast<std::size_t>(fitted - table.name.begin())][1];
  std::ostringstream shown;
  shown << of_sweep;
  EXPECT_THAT(contents(in("one/errors.csv")), HasSubstr(shown.str().substr(0, 5)));
}

/// Of two gains of the steering the first is the car's, the other is 0: taking it out costs nothing.
TEST_F(RealCars, AnEffectThatIsThereTwiceIsTakenOutAtEachPlace) {
  const char* const gains = R"({"plant": {"effects": [{"plugin": "steer_gain", "params": {"k": 0.4}},
                                                      {"plugin": "steer_gain", "params": {"k": 0}}]}})";
  drive("log.csv", gains, {.seconds = 40, .noise = 1});
  std::ofstream(world()) << to_json_text(
      merge(small_car_world(gains), json(R"({"unknowns": {"/plant/params/Cm1": {"sigma": 0.1, "scale": "log"}}})")));
  std::ofstream(in("logs.json")) << R"({"kind": "measured", "world": "world.json", "map": ")" << map()
                                 << R"(", "logs": ["log.csv"], "held_out": {"every": "10 s", "length": "4 s"},
      "claims": ["without_steer_gain_1.position_m <= 0.8 * without_steer_gain_0.position_m"]})";
  const Outcome compared = gripline_with({"compare", in("logs.json"), "--out", in("one")});
  EXPECT_EQ(compared.code, 0) << compared.out << compared.err;
}

/// Each ends with code 2 and one line that says what is wrong and shows the evidence.
TEST_F(RealCars, WrongMapsAndLogsAreRefusedWithTheirEvidence) {
  const Session s = drive("log.csv", "{}", {.seconds = 30});
  const std::string good = contents(map());
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    std::ofstream(map()) << text;
    const Outcome outcome = fit({in("log.csv")});
    EXPECT_EQ(outcome.code, 2) << to;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    return outcome.err;
  };
  EXPECT_THAT(with("\"gyro\"", "\"giro\""),
              AllOf(HasSubstr("/channels/yaw_rate"), HasSubstr("did you mean \"gyro\"?")));
  EXPECT_THAT(with("\"km/h\"", "\"m/s\""), HasSubstr("looks like km/h"));
  EXPECT_THAT(with("\"km/h\"", "\"kg\""), HasSubstr("unit"));
  EXPECT_THAT(with("\"deg\"", "\"rad\""), HasSubstr("yaw"));
  EXPECT_THAT(with("\"steering\"", "\"steering\", \"sign\": -1"), HasSubstr("turns against its steering"));
  EXPECT_THAT(with(R"("column": "steering")", R"("formula": "6 * steering")"),
              AllOf(HasSubstr("the world's delta_max is 0.5"), HasSubstr("the angle of the steering wheel")));
  std::ofstream(map()) << good;

  Session parked = s;
  for (std::size_t i = 0; i < s.rows(); ++i)
    for (std::size_t c = 0; c < channels; ++c) parked.reading[i * channels + c] = c < 3 ? 1.0 : 0.0;
  write("parked.csv", parked);
  const Outcome outcome = fit({in("parked.csv")});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("parked"));
}

TEST_F(RealCars, ALogOfAnotherCarIsToldByWhatItAsksFor) {
  drive("other.csv", R"({"plant": {"params": {"Df": 0.9, "Dr": 0.9, "Bf": 5, "Br": 7}}})",
        {.seconds = 25, .noise = 1, .command = [](double t) {
           return CommandSample<double>{0.3 + 0.1 * std::sin(0.5 * t), 0.3 * std::sin(1.3 * t)};
         }});
  const Outcome outcome = fit({in("other.csv"), "--fit", "tyres", "--starts", "30"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("fitted far outside of its prior: "), HasSubstr("/plant/params/D"),
                                 HasSubstr("standard deviations away"), HasSubstr("another car")));
}

TEST_F(RealCars, ALogThatTellsLittleGivesIntervalsThatSaySo) {
  drive("steady.csv", "{}", {.seconds = 20, .noise = 1, .command = [](double) {
                               return CommandSample<double>{0.3, 0.05};
                             }});
  const Outcome outcome = fit({in("steady.csv")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Node fitted = parse_file(in("fitted.json"));
  for (const Node& p : find_pointer(fitted, "/calibration/parameters")->array()) {
    const std::string pointer = p.find("pointer")->text();
    if (pointer != "/plant/params/Df" && pointer != "/plant/params/Dr") continue;
    const double low = p.find("low")->number(), high = p.find("high")->number();
    EXPECT_LT(low, 6.0) << pointer;
    EXPECT_GT(high, 6.0) << pointer;
    EXPECT_GT(high / low, 1.3) << pointer;
  }
}

}  // namespace test_real_cars
}  // namespace gripline
