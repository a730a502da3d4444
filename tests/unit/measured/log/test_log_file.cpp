#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>

#include "config/errors.hpp"
#include "measured/log/log_file.hpp"
#include "measured/log/log_noise.hpp"
#include "measured/session/session_file.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::measured {
namespace test_log_file {

using test::DiagnoseRig;
using Row = std::array<double, 9>;  // t, six readings, d, delta

class LogFiles : public ::testing::Test {
 protected:
  LogFiles() : folder_(std::filesystem::temp_directory_path() / ("gripline_logs_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
    const Log log = rig_.simulate(rig_.catalogue().null_model(), {20, 51, 1});
    for (std::size_t k = 0; k < log.size(); ++k) {
      Row row{static_cast<double>(k) * log.dt};
      for (std::size_t c = 0; c < channels; ++c) row[1 + c] = log.reading[k * channels + c];
      row[7] = log.command[k].d;
      row[8] = log.command[k].delta;
      rows_.push_back(row);
    }
  }
  ~LogFiles() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::vector<Row>& rows, const std::string& header = usual) const {
    const auto file = folder_ / "log.csv";
    std::ofstream out(file);
    out.precision(10);
    out << header << '\n';
    for (const Row& row : rows)
      for (std::size_t i = 0; i < row.size(); ++i) {
        if (!std::isnan(row[i])) out << row[i];
        out << (i + 1 == row.size() ? "\n" : ",");
      }
    return file;
  }
  LogFile read(const std::vector<Row>& rows) const { return read_log_file(write(rows), {2.0, nullptr}); }
  std::string refusal(const std::vector<Row>& rows, const std::string& header = usual) const {
    try {
      (void)read_log_file(write(rows, header), {2.0, nullptr});
    } catch (const InputError& e) {
      const std::string text = e.what();
      EXPECT_EQ(text.find('\n'), std::string::npos) << text;
      return text;
    }
    return "accepted";
  }
  std::vector<Row> changed(const std::function<void(std::size_t, Row&)>& change) const {
    std::vector<Row> rows = rows_;
    for (std::size_t i = 0; i < rows.size(); ++i) change(i, rows[i]);
    return rows;
  }
  static bool mentions(const LogFile& log, const std::string& check) {
    return std::any_of(log.health.begin(), log.health.end(), [&](const Finding& h) { return h.check == check; });
  }

  static constexpr const char* usual = "t_s,x_m,y_m,yaw_rad,vx_mps,vy_mps,yaw_rate_radps,d,delta_rad";
  DiagnoseRig rig_;
  std::filesystem::path folder_;
  std::vector<Row> rows_;
};

TEST_F(LogFiles, AGoodLogIsTakenAsItIs) {
  const LogFile log = read(rows_);
  ASSERT_EQ(log.stretches.size(), 1U);
  EXPECT_NEAR(log.stretches[0].dt, 0.02, 1e-12);
  ASSERT_EQ(log.stretches[0].size(), rows_.size());
  EXPECT_NEAR(log.stretches[0].reading[100 * 6 + 3], rows_[100][4], 1e-9);
  for (const Finding& h : log.health) EXPECT_EQ(h.level, Finding::Level::good) << h.check << ": " << h.found;
}

TEST_F(LogFiles, NoiseIsEstimatedFromTheLog) {
  const LogFile log = read(rows_);
  const Channels sigma = estimate_noise(log.stretches);
  for (std::size_t c = 0; c < channels; ++c)
    EXPECT_NEAR(sigma[c], rig_.world().sensors.channels[c].sigma, 0.12 * sigma[c]) << c;
}

TEST_F(LogFiles, MissingColumnsAreNamedWithTheNearest) {
  const std::string text = refusal(rows_, "t_s,x_m,y_m,yaw_rad,vx_ms,vy_mps,yaw_rate_radps,d,delta_rad");
  EXPECT_NE(text.find("vx_mps"), std::string::npos) << text;
  EXPECT_NE(text.find("did you mean \"vx_ms\""), std::string::npos) << text;
}

TEST_F(LogFiles, OtherColumnsAreLedToAMapAndAFileThatIsNoTableIsNotPrinted) {
  EXPECT_NE(
      refusal(rows_, "t_s,x_m,y_m,yaw_rad,vx_ms,vy_mps,yaw_rate_radps,d,delta_rad").find("gripline import --guess"),
      std::string::npos);
  const std::string one = refusal({}, std::string(4096, 'D'));
  EXPECT_NE(one.find("found: DDDD"), std::string::npos) << one;
  EXPECT_LT(one.size(), 600U);
  std::string many = "a";
  for (int i = 0; i < 500; ++i) many += ",\x01" + std::to_string(i);
  const std::string cut = refusal({}, many);
  EXPECT_NE(cut.find("\\x01"), std::string::npos) << cut;
  EXPECT_NE(cut.find("... (501 columns)"), std::string::npos) << cut;
}

TEST_F(LogFiles, ALastRowThatEndsEarlyIsLeftOut) {
  for (const char* end : {"20.02,1.5,2.5,0.1", "20.02,1,1,1,1,1,1,0.1,-"}) {
    const auto file = write(rows_);
    std::ofstream(file, std::ios::app) << end;
    const LogFile log = read_log_file(file, {2.0, nullptr});
    EXPECT_EQ(log.stretches[0].size(), rows_.size()) << end;
    EXPECT_TRUE(mentions(log, "rows")) << end;
    std::ofstream(file, std::ios::app) << "\n20.04,1,1,1,1,1,1,0.1,0.1\n";
    EXPECT_THROW((void)read_log_file(file, {2.0, nullptr}), InputError) << end;
  }
}

/// A channel of 10 Hz whose last value is written into every row counts as one with empty cells between.
TEST_F(LogFiles, RepeatsOfAHeldChannelAreNoReadings) {
  const LogFile held =
      read(changed([&](std::size_t i, Row& r) { r[1] = rows_[i - i % 5][1], r[2] = rows_[i - i % 5][2]; }));
  const LogFile sparse = read(changed([](std::size_t i, Row& r) {
    if (i % 5 != 0) r[1] = r[2] = std::nan("");
  }));
  EXPECT_TRUE(mentions(held, "x, y"));
  EXPECT_TRUE(same_content(held, sparse));
}

TEST_F(LogFiles, LateralSpeedMayBeAbsent) {
  const LogFile log =
      read_log_file(write(rows_, "t_s,x_m,y_m,yaw_rad,vx_mps,other,yaw_rate_radps,d,delta_rad"), {2.0, nullptr});
  EXPECT_TRUE(mentions(log, "vy_mps"));
  EXPECT_TRUE(std::isnan(log.stretches[0].reading[4]));
}

TEST_F(LogFiles, TimeBackwardIsRefusedWithItsLine) {
  const std::string text = refusal(changed([](std::size_t i, Row& r) { r[0] = i == 500 ? 3.0 : r[0]; }));
  EXPECT_NE(text.find(":502:"), std::string::npos) << text;
  EXPECT_NE(text.find("backward"), std::string::npos) << text;
}

TEST_F(LogFiles, WrappedYawIsMadeContinuous) {
  const LogFile straight = read(rows_);
  const LogFile wrapped =
      read(changed([](std::size_t, Row& r) { r[3] = std::remainder(r[3], 2.0 * std::numbers::pi); }));
  const auto& a = straight.stretches[0].reading;
  const auto& b = wrapped.stretches[0].reading;
  for (std::size_t k = 1; k < rows_.size(); ++k) EXPECT_NEAR(b[k * 6 + 2] - b[2], a[k * 6 + 2] - a[2], 1e-6);
}

/// At 10 Hz more than one row in twenty wraps; in degrees nearly all of them jump.
TEST_F(LogFiles, ACarThatCirclesWrapsOftenInRadians) {
  std::vector<Row> circles;
  for (std::size_t k = 0; k < 300; ++k) {
    const double t = 0.1 * static_cast<double>(k), yaw = 4.0 * t;
    circles.push_back({t, 0.5 * std::sin(yaw), -0.5 * std::cos(yaw), std::remainder(yaw, 2.0 * std::numbers::pi), 2.0,
                       0.0, 4.0, 0.3, 0.12});
  }
  const LogFile log = read(circles);
  ASSERT_EQ(log.stretches.size(), 1U);
  EXPECT_NEAR(log.stretches[0].reading[299 * 6 + 2] - log.stretches[0].reading[2], 4.0 * 29.9, 1e-6);
  for (Row& r : circles) r[3] *= 180.0 / std::numbers::pi;
  EXPECT_NE(refusal(circles).find("degrees"), std::string::npos);
  for (Row& r : circles) r[6] *= 180.0 / std::numbers::pi;
  EXPECT_NE(refusal(circles).find("degrees"), std::string::npos) << "with the yaw rate in degrees too";
}

TEST_F(LogFiles, WrongUnitsAreToldByWhatTheyLookLike) {
  EXPECT_NE(refusal(changed([](std::size_t, Row& r) { r[4] *= 3.6; })).find("km/h"), std::string::npos);
  EXPECT_NE(refusal(changed([](std::size_t, Row& r) { r[3] *= 180 / std::numbers::pi; })).find("degrees"),
            std::string::npos);
  EXPECT_NE(refusal(changed([](std::size_t, Row& r) { r[6] *= 180 / std::numbers::pi; })).find("deg/s"),
            std::string::npos);
  EXPECT_NE(refusal(changed([](std::size_t, Row& r) { r[8] *= 180 / std::numbers::pi; })).find("degrees"),
            std::string::npos);
  EXPECT_NE(refusal(changed([](std::size_t, Row& r) { r[7] *= 100; })).find("per cent"), std::string::npos);
}

TEST_F(LogFiles, AParkedCarAndAShortLogAreRefused) {
  const std::string parked = refusal(changed([&](std::size_t, Row& r) {
    for (std::size_t c = 1; c <= 6; ++c) r[c] = rows_[0][c] * (c < 4 ? 1.0 : 0.0);
  }));
  EXPECT_NE(parked.find("parked"), std::string::npos) << parked;
  const std::string brief = refusal({rows_.begin(), rows_.begin() + 150});
  EXPECT_NE(brief.find("at least 5 s"), std::string::npos) << brief;
}

/// Of a car whose v_ref is 2 m/s: at a tenth of it it drives, though too slowly for anything to be told of it.
TEST_F(LogFiles, ASlowCarIsNotParked) {
  const auto circling = [](double v) {
    std::vector<Row> rows;
    for (std::size_t k = 0; k < 300; ++k) {
      const double t = 0.1 * static_cast<double>(k), rate = 2.0 * v, yaw = rate * t;
      rows.push_back({t, 0.5 * std::sin(yaw), -0.5 * std::cos(yaw), yaw, v, 0.0, rate, 0.1, 0.12});
    }
    return rows;
  };
  const std::string slow = refusal(circling(0.2)), parked = refusal(circling(0.08));
  EXPECT_NE(slow.find("no stretch of 3 s"), std::string::npos) << slow;
  EXPECT_NE(slow.find("at 0.4 m/s or faster, a fifth of the car's v_ref"), std::string::npos) << slow;
  EXPECT_NE(parked.find("the car is parked"), std::string::npos) << parked;
  EXPECT_EQ(refusal(circling(0.5)), "accepted");
}

TEST_F(LogFiles, DroppedRowsOutliersAndNansAreLeftOut) {
  std::vector<Row> rows = changed([](std::size_t i, Row& r) {
    if (i % 97 == 13) r[1 + i % 6] += (i % 2 == 0 ? 1.0 : -1.0) * (1 + i % 6 < 4 ? 0.4 : 3.0);
    if (i == 700) r[4] = std::nan("");
  });
  std::vector<Row> kept;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (i % 50 != 20) kept.push_back(rows[i]);
  const LogFile log = read(kept);
  ASSERT_EQ(log.stretches.size(), 1U);
  EXPECT_EQ(log.stretches[0].size(), rows_.size());
  EXPECT_TRUE(mentions(log, "outliers"));
  EXPECT_TRUE(mentions(log, "rows"));
  EXPECT_TRUE(mentions(log, "readings"));
  // What is left is close to the untouched log.
  for (std::size_t k = 0; k < rows_.size(); ++k)
    for (std::size_t c = 0; c < channels; ++c) {
      const double y = log.stretches[0].reading[k * channels + c];
      if (!std::isnan(y)) {
        EXPECT_NEAR(y, rows_[k][1 + c], 8.0 * rig_.world().sensors.channels[c].sigma) << k << " " << c;
      }
    }
}

TEST_F(LogFiles, LongGapsCutTheLog) {
  std::vector<Row> rows;
  for (const Row& r : rows_)
    if (r[0] < 8.0 || r[0] > 9.0) rows.push_back(r);
  const LogFile log = read(rows);
  ASSERT_EQ(log.stretches.size(), 2U);
  EXPECT_NEAR(log.stretches[1].t0, 9.02, 0.021);
  EXPECT_TRUE(mentions(log, "gaps"));
}

TEST_F(LogFiles, StandingStartsAreLeftOut) {
  const LogFile log = read(changed([](std::size_t i, Row& r) {
    if (i < 60) r[4] = 0.005 * static_cast<double>(i);  // up to 0.3 m/s in 1.2 s; a fifth of v_ref is 0.4 m/s
  }));
  ASSERT_EQ(log.stretches.size(), 1U);
  EXPECT_NEAR(log.stretches[0].t0, 1.2, 0.021);
  EXPECT_TRUE(mentions(log, "speed"));
}

/// As of a camera, a compass or wheels slower than the rows: each in every so many, from the third on.
TEST_F(LogFiles, ChannelsThatAreReadLessOftenThanRowsAreCheckedAllTheSame) {
  const auto thinned = [&](std::vector<std::size_t> columns, std::size_t every, double factor = 1.0) {
    return changed([=](std::size_t i, Row& r) {
      r[4] *= factor;
      for (const std::size_t c : columns)
        if (i % every != 3 % every) r[c] = std::nan("");
    });
  };
  const std::vector<std::vector<std::size_t>> slow = {{1, 2, 3}, {3}, {4}, {6}};
  for (const std::size_t every : {2UL, 10UL})
    for (const std::vector<std::size_t>& columns : slow) {
      const LogFile log = read(thinned(columns, every));
      ASSERT_EQ(log.stretches.size(), 1U);
      EXPECT_TRUE(std::any_of(log.health.begin(), log.health.end(), [](const Finding& h) {
        return h.check == "units" && h.level == Finding::Level::good;
      })) << every;
    }
  EXPECT_NE(refusal(thinned({1, 2, 3}, 10, 3.6)).find("km/h"), std::string::npos);
}

TEST_F(LogFiles, WhatIsReadTooSeldomToBeComparedIsSaid) {
  const LogFile log = read(changed([](std::size_t i, Row& r) {
    if (i % 100 != 3) r[1] = r[2] = std::nan("");  // every two seconds
  }));
  EXPECT_TRUE(std::any_of(log.health.begin(), log.health.end(),
                          [](const Finding& h) { return h.check == "units" && h.level == Finding::Level::bad; }));
}

TEST_F(LogFiles, RowsWithoutASpeedAmongSlowOnesAreLeftOutWithThem) {
  const LogFile log = read(changed([](std::size_t i, Row& r) {
    if (i < 60) r[4] = 0.005 * static_cast<double>(i);
    if (i % 5 != 0) r[4] = std::nan("");
  }));
  ASSERT_EQ(log.stretches.size(), 1U);
  EXPECT_GT(log.stretches[0].t0, 1.0);
}

TEST_F(LogFiles, AnotherTrackIsRefusedALittleOutsideIsNot) {
  const auto on_road = [&](double aside, double away) {
    const Track& track = rig_.road().track();
    std::vector<Row> rows = rows_;
    double s = 0.0;
    for (Row& r : rows) {
      const CurvePoint at = track.at(track.wrap(s));
      r[1] = at.x - aside * std::sin(at.yaw) + away;
      r[2] = at.y + aside * std::cos(at.yaw);
      r[4] = 1.6;
      s += 1.6 * 0.02 * (1.0 - aside * at.kappa > 0.2 ? 1.0 / (1.0 - aside * at.kappa) : 1.0);
    }
    return rows;
  };
  const LogExpectations expected{2.0, &rig_.road()};
  EXPECT_NO_THROW((void)read_log_file(write(on_road(0.2, 0.0)), expected));
  const std::vector<Row> away = on_road(0.0, 6.0);
  std::vector<Row> away_at_5_hz = away;
  for (std::size_t i = 0; i < away.size(); ++i)
    if (i % 10 != 3) away_at_5_hz[i][1] = away_at_5_hz[i][2] = std::nan("");
  for (const std::vector<Row>& rows : {away, away_at_5_hz}) {
    try {
      (void)read_log_file(write(rows), expected);
      ADD_FAILURE() << "accepted";
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find("another track"), std::string::npos) << e.what();
    }
  }
}

TEST_F(LogFiles, UnevenTimeIsBroughtToAGrid) {
  std::mt19937_64 random(3);
  const LogFile log = read(changed([&](std::size_t, Row& r) {
    const double late = 0.002 * (static_cast<double>(random() % 1000) / 1000.0 - 0.5);
    r[1] += late * r[4] * std::cos(r[3]);  // the car was a little further on
    r[2] += late * r[4] * std::sin(r[3]);
    r[3] += late * r[6];
    r[0] += late;
  }));
  ASSERT_EQ(log.stretches[0].size(), rows_.size());
  EXPECT_TRUE(mentions(log, "time"));
}

TEST_F(LogFiles, AHandwheelsAngleIsRefused) {
  double largest = 0;
  for (const Row& r : rows_) largest = std::max(largest, std::abs(r[8]));
  const double ratio = 1.4 / largest;  // below what looks like degrees
  const auto file = write(changed([&](std::size_t, Row& r) { r[8] *= ratio; }));
  EXPECT_NO_THROW((void)read_log_file(file, {2.0, nullptr}));  // nothing is known of the car
  try {
    (void)read_log_file(file, {2.0, nullptr, 0.35});
    ADD_FAILURE() << "accepted";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("angle of the handwheel"), std::string::npos) << e.what();
  }
  EXPECT_NO_THROW((void)read_log_file(write(rows_), {2.0, nullptr, 0.35}));
}

TEST_F(LogFiles, AByteOrderMarkIsNoPartOfTheFirstColumn) {
  const std::string header = std::string("\xef\xbb\xbf") + usual;
  EXPECT_NO_THROW((void)read_log_file(write(rows_, header), {2.0, nullptr}));
}

TEST_F(LogFiles, ColumnsOfOtherNamesAreRecognisedAndTwiceIsTooOften) {
  const std::string other = refusal(rows_, "time,x_m,y_m,heading,vx_mps,vy_mps,yaw_rate_radps,throttle,delta_rad");
  EXPECT_NE(other.find("t_s; did you mean \"time\"?"), std::string::npos) << other;
  EXPECT_NE(other.find("yaw_rad; did you mean \"heading\"?"), std::string::npos) << other;
  EXPECT_NE(other.find("d; did you mean \"throttle\"?"), std::string::npos) << other;
  const std::string twice = refusal(rows_, "t_s,x_m,y_m,yaw_rad,vx_mps,vx_mps,yaw_rate_radps,d,delta_rad");
  EXPECT_NE(twice.find("vx_mps stands there 2 times"), std::string::npos) << twice;
}

TEST_F(LogFiles, SmallUnitsAreToldByWhatTheyLookLike) {
  EXPECT_NE(refusal(changed([](std::size_t, Row& r) { r[0] *= 1e3; })).find("milliseconds"), std::string::npos);
  EXPECT_NE(refusal(changed([](std::size_t, Row& r) { r[1] *= 1e3, r[2] *= 1e3; })).find("millimetres"),
            std::string::npos);
}

TEST_F(LogFiles, UnitsOfSpeedNearEachOtherAreToldApart) {
  for (const auto& [factor, meant] : {std::pair(3600.0 / 1852.0, "looks like knots"),
                                      {1 / 0.44704, "looks like mph"},
                                      {1 / 0.3048, "looks like ft/s"},
                                      {3.6, "looks like km/h"},
                                      {2.7, "; expected about 1"}}) {
    const std::string why = refusal(changed([&](std::size_t, Row& r) { r[4] *= factor; }));
    EXPECT_NE(why.find(meant), std::string::npos) << why;
  }
}

TEST_F(LogFiles, WrongSignsAreHintedAt) {
  EXPECT_NE(refusal(changed([](std::size_t, Row& r) { r[8] = -r[8]; })).find("steering seems to have the other sign"),
            std::string::npos);
  EXPECT_NE(refusal(changed([](std::size_t, Row& r) { r[2] = -r[2]; })).find("left-handed"), std::string::npos);
  EXPECT_NE(refusal(changed([](std::size_t, Row& r) { r[3] += 0.7; })).find("of where yaw_rad points"),
            std::string::npos)
      << "no car slides so far all the time";
  EXPECT_NE(refusal(changed([](std::size_t, Row& r) { r[6] = -r[6]; })).find("yaw_rate_radps seems to have the other"),
            std::string::npos);
}

TEST_F(LogFiles, AColumnWithoutAnyNumberIsNamed) {
  for (const auto& [column, name] : {std::pair(4U, "vx_mps"), {6U, "yaw_rate_radps"}})
    EXPECT_NE(refusal(changed([c = column](std::size_t, Row& r) {
                r[c] = NAN;
              })).find(std::string(name) + " holds no number"),
              std::string::npos);
}

/// A car that stands with its wheels turned says nothing about the sign of the steering, nor, where it stands for
/// nearly all of the log, about the frame.
TEST_F(LogFiles, ACarThatStandsIsNoHint) {
  const double turned = 2.0 - rows_.back()[3], c = std::cos(turned), s = std::sin(turned);
  const std::vector<Row> driven = changed([&](std::size_t, Row& r) {
    const double x = r[1], y = r[2];
    r[1] = c * x - s * y, r[2] = s * x + c * y, r[3] += turned;
  });
  for (const std::size_t times : {2UL, 30UL}) {
    std::vector<Row> rows = driven;
    for (std::size_t i = 0; i < times * driven.size(); ++i) {
      Row row = driven.back();
      row[0] += 0.02 * static_cast<double>(i + 1);
      row[4] = row[5] = row[6] = row[7] = 0.0;
      row[8] = 0.3;
      rows.push_back(row);
    }
    EXPECT_EQ(refusal(rows), "accepted") << times;
  }
}

TEST_F(LogFiles, OutliersOfAnySizeAreLeftOutBeforeAnythingIsJudged) {
  std::mt19937_64 random(11);
  for (const double size : {50.0, 1e308}) {
    const LogFile log = read(changed([&](std::size_t, Row& r) {
      if (random() % 100 == 0) r[1 + random() % 6] += random() % 2 == 0 ? size : -size;
    }));
    ASSERT_EQ(log.stretches.size(), 1U);
    EXPECT_TRUE(mentions(log, "outliers"));
    std::size_t lost = 0;
    for (std::size_t k = 0; k < rows_.size(); ++k)
      for (std::size_t c = 0; c < channels; ++c) {
        const double y = log.stretches[0].reading[k * 6 + c];
        lost += std::isnan(y);
        // Whole turns of the heading may be added to all that follows; what counts is that nothing stands out.
        const double off = c == 2 ? std::remainder(y - rows_[k][1 + c], 2.0 * std::numbers::pi) : y - rows_[k][1 + c];
        if (!std::isnan(y)) {
          EXPECT_LT(std::abs(off), 8.0 * rig_.world().sensors.channels[c].sigma) << size << " " << k << " " << c;
        }
      }
    EXPECT_LT(lost, rows_.size() * 6 / 100);
  }
}

/// As of a car on a straight whose yaw rate is read between its other channels, and is rounded to 0.
TEST_F(LogFiles, ARowOfOneReadingThatIsZeroIsKept) {
  std::vector<Row> rows;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    rows.push_back(rows_[i]);
    if (i % 3 == 0) continue;
    for (std::size_t c = 1; c < 6; ++c) rows.back()[c] = NAN;
    rows.back()[6] = i % 30 == 1 ? 0.0 : rows.back()[6];
  }
  const LogFile log = read(rows);
  ASSERT_EQ(log.stretches.size(), 1U);
  EXPECT_TRUE(log.stretches[0].interpolated.empty());
}

/// As of a logger that writes a command a little after the readings of its row.
TEST_F(LogFiles, ARowWithoutReadingsTakesNoneFromTheSample) {
  std::vector<Row> rows;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    rows.push_back(rows_[i]);
    if (i % 10 != 5) continue;
    rows.push_back(rows_[i]);
    rows.back()[0] += 0.004;
    for (std::size_t c = 1; c < 7; ++c) rows.back()[c] = NAN;
  }
  const LogFile log = read(rows);
  ASSERT_EQ(log.stretches.size(), 1U);
  EXPECT_NEAR(log.stretches[0].reading[105 * channels + Channel::vx], rows_[105][4], 1e-9);
}

TEST_F(LogFiles, BlankRowsGoWithTheirCommandsWhichAreThenGuesses) {
  std::vector<std::size_t> blank;
  const LogFile log = read(changed([&](std::size_t i, Row& r) {
    if (i % 90 != 40) return;
    blank.push_back(i);
    std::fill(r.begin() + 1, r.end(), 0.0);
  }));
  ASSERT_EQ(log.stretches.size(), 1U);
  const Log& m = log.stretches[0];
  ASSERT_EQ(m.interpolated.size(), rows_.size());
  for (const std::size_t i : blank) {
    EXPECT_TRUE(std::isnan(m.reading[i * 6])) << i;
    EXPECT_TRUE(m.interpolated[i]) << i;
    EXPECT_NEAR(m.command[i].d, rows_[i][7], 0.05) << i;
  }
  EXPECT_FALSE(m.interpolated[45]);
  EXPECT_TRUE(read(rows_).stretches[0].interpolated.empty());
}

TEST_F(LogFiles, TheSameLogCountsOnce) {
  LogFile a = read(rows_), b = a, other = read(changed([](std::size_t i, Row&r) { r[4] += i == 9 ? 1e-3 : 0.0; }));
  b.name = "copy.csv";
  const std::vector<LogFile> three{a, b, other};
  const std::vector<LogFile> once = each_once(three);
  ASSERT_EQ(once.size(), 2U);
  EXPECT_TRUE(mentions(once[0], "logs"));
  EXPECT_FALSE(mentions(once[1], "logs"));
  EXPECT_THROW(check_held_out(three, std::vector<LogFile>{b}), InputError);
  EXPECT_NO_THROW(check_held_out(std::vector<LogFile>{a}, std::vector<LogFile>{other}));
}

/// Whichever way the same rows come, they are cleaned and cut alike.
TEST_F(LogFiles, ASessionsEvenGridIsThatOfItsFile) {
  std::vector<Row> rows = changed([](std::size_t i, Row& r) {
    if (i % 97 == 13) r[1 + i % 6] += i % 2 == 0 ? 3.0 : -3.0;
    if (i < 60) r[4] = 0.005 * static_cast<double>(i);
  });
  std::erase_if(rows, [](const Row& r) { return r[0] >= 8.0 && r[0] <= 9.0; });
  const LogFile log = read(rows);
  ASSERT_EQ(log.stretches.size(), 2U);
  const LogFile again = on_even_grid(read_session(write(rows), gripline_map()).session, 2.0);
  ASSERT_EQ(again.stretches.size(), 2U);
  EXPECT_TRUE(same_content(again, log));
  EXPECT_EQ(again.stretches[1].t0, log.stretches[1].t0);
  EXPECT_EQ(again.seconds, log.seconds);
}

/// What diagnose refuses of gripline's own logs may be read well enough for other uses of a logger's.
TEST_F(LogFiles, ASessionsEvenGridMayBeCoarseOrEmpty) {
  std::vector<Row> rows;
  for (std::size_t i = 0; i < rows_.size(); i += 10) rows.push_back(rows_[i]);
  EXPECT_NE(refusal(rows).find("rows are 0.2 s apart"), std::string::npos);
  const Session session = read_session(write(rows), gripline_map()).session;
  const LogFile coarse = on_even_grid(session, 2.0);
  ASSERT_EQ(coarse.stretches.size(), 1U);
  EXPECT_NEAR(coarse.stretches[0].dt, 0.2, 1e-12);
  EXPECT_TRUE(on_even_grid(session, 100.0).stretches.empty());  // of a car that hardly moves
}

}  // namespace test_log_file
}  // namespace gripline::measured
