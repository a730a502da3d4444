#include "measured/table/row_times.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "config/errors.hpp"

namespace gripline::measured {
namespace test_row_times {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

DelimitedTable table_of(std::size_t rows) {
  DelimitedTable table;
  table.file = "drive.csv";
  table.name = {"v"};
  table.unit = {""};
  table.column.resize(1);
  for (std::size_t r = 0; r < rows; ++r) {
    table.column[0].push_back(static_cast<double>(r));
    table.line.push_back(static_cast<int>(r) + 2);
  }
  return table;
}
std::vector<double> every(double step, std::size_t rows) {
  std::vector<double> t;
  for (std::size_t r = 0; r < rows; ++r) t.push_back(step * static_cast<double>(r));
  return t;
}
RowTimes rows_at(std::vector<double> time, std::string* said = nullptr) {
  DelimitedTable table = table_of(time.size());
  std::vector<Finding> findings;
  RowTimes out = order_rows(table, time, false, findings);
  for (const Finding& one : findings)
    if (said != nullptr) *said += one.found + ", " + one.done + "; ";
  return out;
}
std::string why(const std::vector<double>& time) {
  try {
    rows_at(time);
  } catch (const InputError& error) {
    return error.what();
  }
  return "fine";
}

TEST(RowTimes, RowsOfAGoodLogStayAsTheyAre) {
  std::string said;
  const RowTimes out = rows_at(every(0.02, 30), &said);
  EXPECT_EQ(out.row.size(), 30u);
  EXPECT_EQ(out.row[29], 29u);
  EXPECT_DOUBLE_EQ(out.t[29], 0.58);
  EXPECT_NEAR(out.step, 0.02, 1e-12);
  EXPECT_EQ(said, "");
}

TEST(RowTimes, TooFewRowsAreToldHowManyAreNeeded) {
  EXPECT_EQ(why(every(0.2, 20)), "fine");
  EXPECT_NE(why(every(0.2, 19)).find("only 19 rows with a time; expected 20 or more"), std::string::npos);
}

TEST(RowTimes, RowsWithoutATimeAreLeftOut) {
  std::vector<double> time = every(0.1, 30);
  time[3] = time[29] = none;
  std::string said;
  const RowTimes out = rows_at(time, &said);
  EXPECT_EQ(out.row.size(), 28u);
  EXPECT_EQ(out.row[3], 4u);
  EXPECT_EQ(said, "2 without time, left out; ");
}

TEST(RowTimes, RepeatedStampsBecomeOneRowOfTheTable) {
  DelimitedTable table = table_of(42);
  std::vector<double> time;
  for (std::size_t r = 0; r < 42; ++r) time.push_back(0.05 * static_cast<double>(r / 2));
  table.column[0][0] = none;  // filled by its repetition
  std::vector<Finding> findings;
  const RowTimes out = order_rows(table, time, false, findings);
  ASSERT_EQ(out.row.size(), 21u);
  EXPECT_EQ(table.column[0],
            (std::vector<double>{1, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30, 32, 34, 36, 38, 40}));
  EXPECT_EQ(table.line[1], 4);
  EXPECT_EQ(time.size(), 21u);
}

TEST(RowTimes, ThePaceOfBurstsIsTheirMean) {
  std::vector<double> time;
  for (std::size_t r = 0; r < 60; ++r)
    time.push_back(0.1 * static_cast<double>(r / 3) + 1e-6 * static_cast<double>(r % 3));
  EXPECT_NEAR(rows_at(time).step, 0.1 / 3, 2e-3);
}

TEST(RowTimes, AFewRowsBeforeAClockWasSetAreLeftOut) {
  std::vector<double> time = every(0.1, 400);
  for (std::size_t r = 2; r < time.size(); ++r) time[r] += 1.5e9;
  EXPECT_EQ(rows_at(time).row.front(), 2u);
  std::vector<double> late = every(0.1, 400);
  for (std::size_t r = 200; r < late.size(); ++r) late[r] += 4000;
  EXPECT_NE(why(late).find("drive.csv:202:0: time steps by 4e+03 s"), std::string::npos) << why(late);
}

TEST(RowTimes, RefusalsSayWhatTimeLooksLike) {
  EXPECT_NE(why(every(20, 40)).find("looks like milliseconds"), std::string::npos);
  EXPECT_NE(why(every(2e-5, 40)).find("taken for milliseconds and is seconds"), std::string::npos);
  EXPECT_NE(why(every(0.7, 40)).find("0.7 s apart (1.43 Hz); expected 0.5 s or less"), std::string::npos);
  const std::string one = why(every(1, 40));
  EXPECT_NE(one.find("rows are 1 s apart (1 Hz); expected 0.5 s or less (2 Hz)"), std::string::npos) << one;
  EXPECT_NE(one.find("if the numbers are milliseconds (1000 Hz)"), std::string::npos) << one;
  EXPECT_EQ(one.find("looks like"), std::string::npos) << one;
  EXPECT_NE(why(every(0.1, 19)).find("only 19 rows"), std::string::npos);
  std::vector<double> back = every(0.1, 40);
  back[20] = 0.05;
  EXPECT_NE(why(back).find("drive.csv:22:0: time runs backward by 1.85 s"), std::string::npos) << why(back);
}

}  // namespace
}  // namespace test_row_times
}  // namespace gripline::measured
