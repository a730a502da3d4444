#include "report/report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <random>
#include <regex>
#include <sstream>

#include "config/errors.hpp"
#include "config/hash.hpp"
#include "report/bundle.hpp"
#include "report/columns.hpp"
#include "report/inputs.hpp"
#include "report/packing.hpp"
#include "report/page.hpp"
#include "report/plot.hpp"
#include "report/series.hpp"
#include "report/tables.hpp"
#include "support/paths.hpp"
#include "support/report_sample.hpp"

namespace gripline::report {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr double gap = std::numeric_limits<double>::quiet_NaN();

/// A folder of its own for each test, gone afterwards.
class Folder {
 public:
  Folder() {
    const testing::TestInfo& test = *testing::UnitTest::GetInstance()->current_test_info();
    path_ = fs::temp_directory_path() / ("gripline_" + std::string(test.test_suite_name()) + "_" + test.name());
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<std::uint8_t> decoded(const std::string& text) {
  static const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<std::uint8_t> bytes;
  std::uint32_t word = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    word = word << 6 | static_cast<std::uint32_t>(digits.find(c));
    bits += 6;
    if (bits >= 8) bytes.push_back(static_cast<std::uint8_t>(word >> (bits -= 8)));
  }
  return bytes;
}

/// What the page makes of a packed column: an independent reading of the format that packing.hpp states.
std::vector<double> unpacked(const nlohmann::json& column) {
  const auto n = column["n"].get<std::size_t>();
  const std::string kind = column["k"];
  const double offset = column["o"].is_null() ? gap : column["o"].get<double>(), step = column.value("s", 0.0);
  std::vector<double> values(n, offset);
  const std::vector<std::uint8_t> bytes = decoded(column.value("b", ""));
  for (std::size_t i = 0; i < n; ++i) {
    if (kind == "u") values[i] = offset + step * static_cast<double>(i);
    if (kind == "f") {
      std::uint32_t word = 0;
      for (std::size_t k = 0; k < 4; ++k) word |= static_cast<std::uint32_t>(bytes[4 * i + k]) << (8 * k);
      values[i] = offset + static_cast<double>(std::bit_cast<float>(word));
    }
    if (kind == "h") {
      const auto code = static_cast<std::int16_t>(bytes[2 * i] | bytes[2 * i + 1] << 8);
      values[i] = code == -32768 ? gap : offset + step * code;
    }
  }
  return values;
}

TEST(ReportColumns, ReadsNumbersTextsAndQuotes) {
  const Columns table = Columns::parse("stack,v,w\n\"a,\"\"b\"\"\",1.5,\nplain,-2e3,x\n", true);
  EXPECT_EQ(table.rows(), 2u);
  EXPECT_EQ(table.text("stack", 0), "a,\"b\"");
  EXPECT_EQ(table.text("stack", 1), "plain");
  EXPECT_EQ(table.number("v", 1), -2000);
  EXPECT_TRUE(std::isnan(table.number("w", 0)));
  EXPECT_TRUE(std::isnan(table.number("w", 1)));
  EXPECT_TRUE(std::isnan(table.number("absent", 0)));
  EXPECT_TRUE(table.numbers("absent").empty());
}

TEST(ReportColumns, ALineCutOffWhileWritingIsDropped) {
  EXPECT_EQ(Columns::parse("t,x\n0,1\n0.1,2\n0.2,3.14").rows(), 2u);
  EXPECT_EQ(Columns::parse("t,x\r\n0,1\r\n").number("x", 0), 1);
  EXPECT_EQ(Columns::parse("").rows(), 0u);
}

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

TEST(ReportTables, IntervalOfTheMedianByOrderStatistics) {
  std::vector<double> ten{10, 1, 9, 2, 8, 3, 7, 4, 6, 5};
  EXPECT_EQ(median_of_numbers(ten), 5.5);
  // n = 10: second smallest to second largest, covering 97.9 %.
  EXPECT_EQ(median_interval(ten).low, 2);
  EXPECT_EQ(median_interval(ten).high, 9);
  const std::vector<double> three{3, gap, 1, 2};
  EXPECT_EQ(median_of_numbers(three), 2);
  EXPECT_EQ(median_interval(three).low, 1);
  EXPECT_TRUE(std::isnan(median_interval(std::vector<double>{1}).low));
  EXPECT_TRUE(std::isnan(median_of_numbers(std::vector<double>{})));
  // n = 20: the sixth, P(Binomial(20, 1/2) <= 5) = 0.0207.
  std::vector<double> twenty(20);
  for (std::size_t i = 0; i < twenty.size(); ++i) twenty[i] = static_cast<double>(i + 1);
  EXPECT_EQ(median_interval(twenty).low, 6);
}

TEST(ReportTables, ClaimsKeepWhatWasSkipped) {
  const nlohmann::json claims = claims_json(nlohmann::json::parse(R"({"claims": [{"text": "a.x <= b.x", "holds": false,
    "values": {"left": 2, "right": 1}}], "skipped": [{"text": "c", "why": "left out"}]})"));
  ASSERT_EQ(claims.size(), 2u);
  EXPECT_EQ(claims[0]["holds"], false);
  EXPECT_EQ(claims[0]["values"]["left"], 2);
  EXPECT_TRUE(claims[1]["holds"].is_null());
  EXPECT_EQ(claims[1]["why"], "left out");
}

TEST(ReportTables, TimesPooledOnALogarithmicAxis) {
  TimeHistogram histogram;
  for (int i = 1; i <= 100; ++i) histogram.add(0.01 * i);
  histogram.add(gap);
  histogram.add(-1);
  const nlohmann::json json = histogram.json();
  EXPECT_EQ(json["n"], 100);
  EXPECT_NEAR(json["median"].get<double>(), 0.5, 0.011);
  EXPECT_NEAR(json["max"].get<double>(), 1.0, 1e-6);
  long counted = 0;
  for (const nlohmann::json& bin : json["bins"]) counted += bin[1].get<long>();
  EXPECT_EQ(counted, 100);
}

/// The JSON of one of the page's data blocks.
nlohmann::json block(const std::string& html, const std::string& id) {
  const std::string open = "<script type=\"application/json\" id=\"" + id + "\">";
  const std::size_t begin = html.find(open) + open.size();
  return nlohmann::json::parse(html.substr(begin, html.find("</script>", begin) - begin));
}

TEST(ReportPage, DetailStaysWithinTheBudget) {
  EXPECT_EQ(choose_detail({22 * 9000.0, 9e4, 1e4}).stride, 1u);
  EXPECT_EQ(choose_detail({22 * 9000.0, 9e4, 1e4}).precision, Precision::single);
  // Steps of all runs; a snapshot of the curves, 82 rows of four numbers, comes once in 50 of them.
  for (const double rows : {5e4, 1.3e5, 6.1e5, 5e6}) {
    const Cells cells = {22 * rows, 48 * rows / 5, 328 * rows / 50};
    const Detail detail = choose_detail(cells);
    EXPECT_EQ(detail.precision, Precision::half);
    EXPECT_EQ(detail.stride, detail.replay_stride);
    const double kept = (cells.steps + cells.replay) / static_cast<double>(detail.stride) +
                        cells.tyres / static_cast<double>(detail.tyre_stride);
    EXPECT_LE(kept * 8 / 3, page_budget);
    EXPECT_LT(detail.stride, 1.5 + 1.2 * (cells.steps + cells.replay) * 8 / 3 / page_budget)
        << "more is lost than needs be";
  }
}

TEST(ReportPage, ThinnedTyreCurvesKeepTheFirstAndTheLast) {
  const Folder folder;
  sample::SampleOptions options;
  options.seeds = 30;
  sample::write_sample(folder.path(), options);
  const std::string html = bytes_of(write_report({folder.path(), {}, false, {}, {}}).page);
  EXPECT_LT(html.size(), 15u << 20);
  const Columns tyres = Columns::read(folder.path() / "elm" / "1" / "tyres.csv", true);
  const nlohmann::json front = block(html, "run-60")["tyres"]["front"];
  EXPECT_EQ(front["t"].front(), 0.0);
  EXPECT_EQ(front["t"].back(), tyres.number("t_s", tyres.rows() - 1));
  EXPECT_LT(front["t"].size(), tyres.rows() / 82) << "thinned";
  EXPECT_EQ(front["start"].size(), front["t"].size());
  EXPECT_EQ(front["slip"]["n"], 41 * front["t"].size());
}

TEST(ReportPage, HoldsTheLogAndNothingFromOutside) {
  const Folder folder;
  sample::write_sample(folder.path());
  const Written written = write_report({folder.path(), {}, false, {}, {}});
  const std::string html = bytes_of(written.page);
  EXPECT_EQ(html.size(), written.bytes);
  EXPECT_LT(html.size(), 6u << 20);  // five rows, four laps
  EXPECT_FALSE(std::regex_search(html, std::regex(R"((src|href)\s*=\s*["']?(https?:)?//)")));
  EXPECT_THAT(html, HasSubstr("default-src 'none'"));

  const nlohmann::json meta = block(html, "meta");
  EXPECT_EQ(meta["title"], "sample");
  EXPECT_EQ(meta["stacks"].size(), 5u);
  EXPECT_EQ(meta["stacks"][3]["truth"], true);
  EXPECT_EQ(meta["table"]["rows"].size(), 5u);
  const Columns steps = Columns::read(folder.path() / "elm" / "1" / "steps.csv");
  const nlohmann::json run = block(html, "run-2");
  const std::vector<double> x = unpacked(run["steps"]["x"]), t = unpacked(run["steps"]["t"]);
  ASSERT_EQ(x.size(), steps.rows());
  for (std::size_t i = 0; i < x.size(); ++i) {
    ASSERT_NEAR(x[i], steps.number("x_true_m", i), 1e-6);
    ASSERT_NEAR(t[i], steps.number("t_s", i), 1e-6);
  }
}

TEST(ReportPage, SameFolderSameBytes) {
  const Folder folder;
  sample::SampleOptions options;
  options.laps = 1;
  sample::write_sample(folder.path(), options);
  const std::string first = bytes_of(write_report({folder.path(), folder.path() / "a.html", false, {}, {}}).page);
  EXPECT_EQ(first, bytes_of(write_report({folder.path(), folder.path() / "b.html", false, {}, {}}).page));
}

TEST(ReportPage, NamesAndNumbersDoNoHarm) {
  const Folder folder;
  sample::SampleOptions options;
  options.laps = 1;
  options.stacks = {{"a \"b\" <i>\xc3\xbc, 'c' & d", false, 1, 0.9, 0.8}, {"--> ]]>", false, 0, 0.9, 0.8}};
  sample::write_sample(folder.path(), options);
  std::ofstream(folder.path() / "scene.json")
      << R"({"name": "</title></script><script>alert(1)</script>", "note": "<!-- </SCRIPT > \u2028 --!>"})";
  std::ofstream(folder.path() / "claims.json")
      << R"({"claims": [{"text": "</script><img src=x onerror=alert(1)>", "holds": true, "values": {"left": 1e308, "right": -1e308}}]})";
  // One value beyond everything, in the middle of the speed.
  const fs::path steps = folder.path() / "--> ]]>" / "1" / "steps.csv";
  std::string text = bytes_of(steps);
  const std::size_t line = text.find('\n', text.size() / 2) + 1;
  std::size_t cell = line;
  for (int i = 0; i < 12; ++i) cell = text.find(',', cell) + 1;
  text.replace(cell, text.find(',', cell) - cell, "1e308");
  std::ofstream(steps) << text;

  const std::string html = bytes_of(write_report({folder.path(), {}, false, {}, {}}).page);
  EXPECT_THAT(html, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(html, Not(HasSubstr("<img src=x")));
  EXPECT_EQ(block(html, "meta")["stacks"][0]["name"], options.stacks[0].name);
  const nlohmann::json run = block(html, "run-1");
  EXPECT_GE(run["undrawable"].get<int>(), 1);
  for (const double v : unpacked(run["steps"]["vx"])) EXPECT_TRUE(std::isnan(v) || std::abs(v) < 10);
}

TEST(ReportPage, LeavesOutWhatIsMissing) {
  const Folder folder;
  const fs::path run = folder.path() / "only" / "1";
  fs::create_directories(run);
  std::ofstream(run / "steps.csv") << "t_s,x_m,y_m\n0,0,0\n0.02,0.1,0\n0.04,0.2,";
  const std::string html = bytes_of(write_report({folder.path(), {}, true, {}, {}}).page);
  EXPECT_EQ(block(html, "meta")["stacks"][0]["name"], "only");
  EXPECT_EQ(unpacked(block(html, "run-0")["steps"]["x"]).size(), 2u);
}

std::string title_of_page(const fs::path& folder) {
  const std::string html = bytes_of(write_report({folder, {}, false, {}, {}}).page);
  const std::string title = block(html, "meta")["title"];
  EXPECT_THAT(html, HasSubstr("<title>" + title + " · gripline</title>"));
  return title;
}

TEST(ReportPage, AnExperimentThatWasCutShortHasItsRunsAndNoTable) {
  const Folder cut;
  const fs::path folder = cut.path();
  sample::write_sample(folder, sample::SampleOptions{});
  for (const char* table : {"runs.csv", "table.csv"}) fs::remove(folder / table);
  fs::copy(folder / "elm" / "1", folder / "elm" / ".2.partial");
  std::ofstream(folder / "elm" / "1" / "summary.json") << R"({"status": "crashed", "message": "hit a wall"})";
  const Inputs inputs = read_inputs(folder);
  ASSERT_EQ(inputs.runs.size(), 5u) << "the partial run is none";
  const auto elm =
      std::find_if(inputs.runs.begin(), inputs.runs.end(), [](const RunName& r) { return r.stack == "elm"; });
  EXPECT_EQ(elm->status, "crashed");
  EXPECT_EQ(elm->message, "hit a wall");
  EXPECT_EQ(table_json(inputs)["rows"].size(), 0u);
}

TEST(ReportPage, IsNamedAfterWhatItShowsAndNotAfterItsFolder) {
  const Folder folder;
  sample::write_validation_sample(folder.path() / "v");
  EXPECT_EQ(title_of_page(folder.path() / "v"), "v") << "nothing else to call it";
  std::ofstream(folder.path() / "v" / "scene.json")
      << R"({"name": "offline_validation", "kind": "offline_validation"})";
  EXPECT_EQ(title_of_page(folder.path() / "v"), "offline_validation");
  sample::write_diagnosis_sample(folder.path() / "d");
  EXPECT_EQ(title_of_page(folder.path() / "d"), "measured.csv");
  std::ofstream(folder.path() / "d" / "scene.json") << R"({"name": "drag of hidden", "kind": "diagnosis"})";
  EXPECT_EQ(title_of_page(folder.path() / "d"), "drag of hidden");
}

TEST(ReportPage, CasesOfADiagnoseExperimentAreAnOverview) {
  const Folder folder;
  sample::write_cases_sample(folder.path());
  const nlohmann::json meta = block(bytes_of(write_report({folder.path(), {}, false, {}, {}}).page), "meta");
  ASSERT_EQ(meta["cases"].size(), 2u);
  EXPECT_EQ(meta["cases"][0]["case"], "drag");
  EXPECT_EQ(meta["cases"][0]["verdict"], "named");
  EXPECT_EQ(meta["cases"][0]["sentence"], "aero_drag (a = -0.42 m/s2) is missing.");
  EXPECT_EQ(meta["cases"][0]["page"], true);
  EXPECT_DOUBLE_EQ(meta["cases"][0]["values"]["before"].get<double>(), 5.19);
  EXPECT_EQ(meta["cases"][1]["page"], false);
  EXPECT_EQ(meta["cases"][1]["sentence"], "");
  EXPECT_TRUE(meta["runs"].empty()) << "the drives of a case are no race";
}

/// What no gripline wrote: rows twice, names that lead elsewhere, trees without end.
TEST(ReportPage, EditedTablesAreDrawnOrRefusedWithTheirPlace) {
  const Folder folder;
  const auto write = [&](const char* name, const std::string& text) { std::ofstream(folder.path() / name) << text; };
  const auto why = [&] {
    try {
      write_report({.folder = folder.path(), .page = {}, .figures = true, .figure_folder = {}, .progress = {}});
      return std::string("written");
    } catch (const InputError& error) {
      return std::string(error.what());
    }
  };
  write("runs.csv", "stack,seed,status\nelm,1,finished\n");
  std::string rows = "stack,lap0_s,pace_ratio0,violation_s\n";
  for (int i = 0; i < 40; ++i) rows += "elm,7.5,1.01,0.2\n";
  write("table.csv", rows + "gp,7.6,1.02,0.1\n");
  EXPECT_EQ(why(), "written");
  write("table.csv", "stack,violation_s,pace_ratio0\nelm,5e-324,1e308\ngp,1e-310,1000000000.0000001\n");
  EXPECT_EQ(why(), "written");
  const std::string runs = (folder.path() / "runs.csv").string();
  write("runs.csv", "stack,seed,status\nelm,1,finished\n" + std::string(300, 'x') + ",1,finished\n");
  EXPECT_THAT(why(), testing::StartsWith(runs + ": row 2: \"xxx"));
  write("runs.csv", "stack,seed,status\nelm,../../elsewhere,finished\n");
  EXPECT_THAT(why(), HasSubstr("row 1: \"../../elsewhere\" is no folder's name"));
  write("runs.csv", "stack,seed,status\nelm,1,finished\n");
  write("claims.json", std::string(100'000, '[') + std::string(100'000, ']'));
  EXPECT_EQ(why(), (folder.path() / "claims.json").string() + ": nested deeper than 200 levels");
}

TEST(ReportPage, RefusesAFolderWithoutResults) {
  const Folder folder;
  for (const fs::path& path : {folder.path(), folder.path() / "absent"}) {
    try {
      write_report({path, {}, false, {}, {}});
      ADD_FAILURE() << path;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(path.string()));
      EXPECT_THAT(error.what(), HasSubstr("expected"));
    }
  }
}

TEST(ReportPage, ManySeedsStaySmallAndAreWrittenQuickly) {
  const Folder folder;
  sample::SampleOptions options;
  options.seeds = 10;
  options.stacks.push_back({"elm_rls", false, 1, 0.92, 0.4});
  options.stacks.push_back({"best", false, 1, 0.96, 0.5});
  sample::write_sample(folder.path(), options);
  const std::clock_t begin = std::clock();
  const Written written = write_report({folder.path(), {}, false, {}, {}});
  const double cpu_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  EXPECT_LT(written.bytes, 15u << 20);
  // The cheapest stacks are to take two CPU-seconds a run: 5 % of seventy runs.
  EXPECT_LT(cpu_s, 0.05 * 70 * 2);
  RecordProperty("bytes", std::to_string(written.bytes));
}

TEST(ReportFigures, AreWholeDrawings) {
  const Folder race, validation, diagnosis;
  sample::write_sample(race.path() / "race");
  sample::write_validation_sample(race.path() / "validation");
  sample::write_diagnosis_sample(race.path() / "diagnosis");
  std::map<std::string, std::vector<std::string>> expected{
      {"race", {"trajectories", "speed", "friction", "tyre_curves", "g_g", "laps", "step_times", "pareto"}},
      {"validation", {"offline_validation", "force_validation"}},
      {"diagnosis", {"diagnosis_gap", "diagnosis_residual", "diagnosis_traces"}}};
  for (const auto& [kind, names] : expected) {
    const Written written = write_report({race.path() / kind, {}, true, {}, {}});
    std::vector<std::string> found;
    for (const fs::path& figure : written.figures) {
      found.push_back(figure.stem().string());
      const std::string svg = bytes_of(figure);
      EXPECT_TRUE(svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\"")) << figure;
      EXPECT_TRUE(svg.ends_with("</svg>\n"));
      EXPECT_THAT(svg, Not(testing::ContainsRegex("nan|inf[^o]")));
      EXPECT_THAT(svg, HasSubstr("<path d=\"M"));
      EXPECT_THAT(svg, Not(testing::ContainsRegex(">-[0-9]"))) << figure << ": a hyphen for a minus";
      if (figure.stem() == "step_times") {
        EXPECT_THAT(svg, Not(HasSubstr(">0.0001<"))) << "no step of the sample is that short";
      }
    }
    EXPECT_THAT(found, testing::UnorderedElementsAreArray(names)) << kind;
  }
}

/// Rows over several runs show how sure their medians are.
TEST(ReportFigures, IntervalsOfTheTableAreDrawn) {
  const Folder folder;
  const auto lines_of = [&](const std::string& figure, const std::string& more_names, const std::string& more_cells) {
    std::ofstream(folder.path() / "table.csv")
        << "stack,lap0_s,violation_s,pace_ratio0" << more_names << "\nelm,8.5,0.2,1.05" << more_cells << "\n";
    std::ofstream(folder.path() / "runs.csv") << "stack,seed,status\nelm,1,finished\n";
    (void)write_report({folder.path(), {}, true, {}, {}});
    const std::string svg = bytes_of(folder.path() / "figures" / (figure + ".svg"));
    const std::regex path(series_colour(0));
    return std::distance(std::sregex_iterator(svg.begin(), svg.end(), path), std::sregex_iterator());
  };
  const std::string names = ",lap0_s_lo,lap0_s_hi,violation_s_lo,violation_s_hi,pace_ratio0_lo,pace_ratio0_hi";
  EXPECT_EQ(lines_of("laps", names, ",8.4,8.7,0.1,0.4,1.04,1.07"), lines_of("laps", "", "") + 1);
  EXPECT_EQ(lines_of("pareto", names, ",8.4,8.7,0.1,0.4,1.04,1.07"), lines_of("pareto", "", "") + 2);
  EXPECT_EQ(lines_of("laps", names, ",,,,,,"), lines_of("laps", "", ""));
}

TEST(ReportFigures, DrivesOfTheirOwnHavePanelsOfTheirOwn) {
  const Folder folder;
  const auto panels = [&](const std::string& name, bool own_drives) {
    sample::write_validation_sample(folder.path() / name, own_drives);
    const Written written = write_report({folder.path() / name, {}, true, {}, {}});
    const std::string svg = bytes_of(folder.path() / name / "figures" / "offline_validation.svg");
    std::size_t count = 0;
    for (std::size_t at = 0; (at = svg.find("<clipPath", at)) != svg.npos; ++at) ++count;
    return count;
  };
  EXPECT_EQ(panels("one", false), 3u);
  EXPECT_EQ(panels("own", true), 6u);
}

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

// --- The bundle -----------------------------------------------------------------------------------------------------

const fs::path source = testing_support::source_dir() / "tools" / "report";

TEST(ReportBundle, IsTheCommittedOne) {
  EXPECT_EQ(bundled_script(), bytes_of(source / "dist" / "report.js"));
  EXPECT_EQ(bundled_style(), bytes_of(source / "dist" / "report.css"));
  EXPECT_GT(bundled_script().size(), 50000u);
}

TEST(ReportBundle, WasBuiltFromTheSourceBesideIt) {
  std::map<std::string, std::string> files;  // sorted as build.mjs does
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(source / "src"))
    if (entry.path().extension() == ".ts" || entry.path().extension() == ".css")
      files["src/" + fs::relative(entry.path(), source / "src").generic_string()] = bytes_of(entry.path());
  for (const char* name : {"build.mjs", "package-lock.json"}) files[name] = bytes_of(source / name);
  std::string all;
  for (const auto& [name, text] : files) all += name + "\n" + std::to_string(text.size()) + "\n" + text;
  const std::string stamp = "source " + sha256_hex(all);
  EXPECT_THAT(std::string(bundled_script().substr(0, 200)), HasSubstr(stamp))
      << "tools/report/dist is older than its source; run: (cd tools/report && npm ci && npm run build)";
  EXPECT_THAT(std::string(bundled_style().substr(0, 200)), HasSubstr(stamp));
}

TEST(ReportBundle, CannotEndItsScript) {
  EXPECT_THAT(std::string(bundled_script()), Not(HasSubstr("</script")));
  EXPECT_THAT(std::string(bundled_style()), Not(HasSubstr("</style")));
}

}  // namespace
}  // namespace gripline::report
