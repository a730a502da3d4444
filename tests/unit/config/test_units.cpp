#include "config/units.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <locale>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace gripline {
namespace test_units {

using std::numbers::pi;

std::string why(const std::string& text, const std::string& unit) {
  try {
    return "accepted as " + std::to_string(to_si(text, unit));
  } catch (const UnitError& error) {
    return error.what();
  }
}

TEST(Units, ConvertToSi) {
  struct Case {
    const char* text;
    const char* unit;
    double si;
  };
  const std::vector<Case> cases{{"20 deg", "rad", pi / 9},
                                {"20\u00b0", "rad", pi / 9},
                                {"5 mrad", "rad", 0.005},
                                {"20 ms", "s", 0.02},
                                {"20ms", "s", 0.02},
                                {" 6.2 s ", "s", 6.2},
                                {"1.5 min", "s", 90},
                                {"2 h", "s", 7200},
                                {"2 cm", "m", 0.02},
                                {"-3 mm", "m", -0.003},
                                {"5 km/h", "m/s", 5 / 3.6},
                                {"36 km/h", "m/s", 10},
                                {"3600 kn", "m/s", 1852},
                                {"0.2 deg/s", "rad/s", pi / 900},
                                {"3000 rpm", "rad/s", 100 * pi},
                                {"1 rev/s", "rad/s", 2 * pi},
                                {"0.0518 N", "N", 0.0518},
                                {"1 kN", "N", 1000},
                                {"50 %", "1", 0.5},
                                {"50%", "-", 0.5},
                                {"7 1", "1", 7},
                                {"7 -", "", 7},
                                {"41 g", "kg", 0.041},
                                {"1.2 kg", "kg", 1.2},
                                {"1 mg", "kg", 1e-6},
                                {"3 N s/m", "N s/m", 3},
                                {"3 kg/s", "N s/m", 3},
                                {"3 N*s/m", "N s/m", 3},
                                {"3 N\u00b7s/m", "kg/s", 3},
                                {"2 kg m2", "kg m2", 2},
                                {"2 kg m^2", "kg m2", 2},
                                {"2 kg m\u00b2", "kg m2", 2},
                                {"2 g cm2", "kg m2", 2e-7},
                                {"4 1/s", "1/s", 4},
                                {"4 Hz", "1/s", 4},
                                {"4 s^-1", "1/s", 4},
                                {"9.81 m/s2", "m/s2", 9.81},
                                {"9.81 m/s/s", "m/s2", 9.81},
                                {"9.81 m s-2", "m/s2", 9.81},
                                {"8 km/(h s)", "m/s2", 8 / 3.6},
                                {"2 N/(m2/s2)", "kg/m", 2},
                                {"60 kN/rad", "N/rad", 60000},
                                {"1 kN/deg", "N/rad", 1000 * 180 / pi},
                                {"3 N m", "J", 3},
                                {"3 V", "W/A", 3},
                                {"2 ohm", "V/A", 2},
                                {"2 bar", "Pa", 2e5},
                                {"0.1 1/s^0.5", "1/s^0.5", 0.1},
                                {"3 s^-0.5", "1/s^0.5", 3},
                                {"3 Hz^0.5", "1/s^0.5", 3},
                                {"2 m/s^1.5", "m/s^1.5", 2},
                                {"6 1/min^0.5", "1/s^0.5", 6 / std::sqrt(60.0)},
                                {"3 (m2)^0.5", "m", 3},
                                {"1e-3 m", "m", 1e-3}};
  for (const Case& one : cases) {
    EXPECT_DOUBLE_EQ(to_si(one.text, one.unit), one.si) << one.text << " as " << one.unit;
  }
}

TEST(Units, KeepKindsApart) {
  EXPECT_EQ(why("6.2 m", "s"), "\"6.2 m\" is a length, expected a time [s]");
  EXPECT_EQ(why("20 kg", "rad"), "\"20 kg\" is a mass, expected an angle [rad]");
  EXPECT_EQ(why("20 deg", "1"), "\"20 deg\" is an angle, expected a pure number");
  EXPECT_EQ(why("5 %", "m"), "\"5 %\" is a pure number, expected a length [m]");
  EXPECT_EQ(why("4 1/s", "rad/s"), "\"4 1/s\" is a frequency, expected an angular rate [rad/s]");
  EXPECT_EQ(why("4 m2/(kg s)", "kg/m"), "\"4 m2/(kg s)\" is a quantity in m2/(kg s), expected a quantity [kg/m]");
  EXPECT_EQ(why("1 1/s^0.5", "1/s"), "\"1 1/s^0.5\" is a quantity in 1/s^0.5, expected a frequency [1/s]");
  EXPECT_EQ(why("1 g", "m/s2"), "\"1 g\" is a mass, expected an acceleration [m/s2]");
}

TEST(Units, RefuseWhatIsNoQuantity) {
  using testing::HasSubstr;
  for (const char* text : {"", " ", "s", "fast", "nan s", "inf s", "-inf s", "- 5 s", "+5 s", "e5 s", "."}) {
    EXPECT_THAT(why(text, "s"), HasSubstr("is not a finite number with a unit, expected a time [s]")) << text;
  }
  EXPECT_EQ(why("0.02", "s"), "\"0.02\" has no unit: write 0.02 without quotes, or \"0.02 s\"");
  EXPECT_EQ(why("0.02", "1"), "\"0.02\" is text: write 0.02 without quotes");
  EXPECT_EQ(why("0,02 s", "s"), "\"0,02 s\" has a comma; the decimal mark is a point");
  EXPECT_EQ(why("1e999 s", "s"), "\"1e999 s\" is too large or too small for a number");
  EXPECT_EQ(why("1e308 km", "m"), "\"1e308 km\" is too large for a number");
}

TEST(Units, RefuseWhatIsNoUnit) {
  using testing::HasSubstr;
  EXPECT_EQ(why("20 msec", "s"), "\"20 msec\": unknown unit \"msec\"; did you mean \"ms\"?");
  EXPECT_EQ(why("20 degs", "rad"), "\"20 degs\": unknown unit \"degs\"; did you mean \"deg\"?");
  EXPECT_EQ(why("20 knots", "m/s"), "\"20 knots\": unknown unit \"knots\"; did you mean \"kn\"?");
  EXPECT_EQ(why("2 fortnights", "s"), "\"2 fortnights\": unknown unit \"fortnights\"; expected a time [s]");
  EXPECT_THAT(why("3 Nm", "N m"), HasSubstr("did you mean \"N m\"?"));
  EXPECT_THAT(why("3 N/m s", "N s/m"), HasSubstr("a product after a quotient needs brackets"));
  EXPECT_THAT(why("3 N/(m s", "N"), HasSubstr("a bracket is not closed"));
  EXPECT_THAT(why("3 N)", "N"), HasSubstr("a closing bracket too many"));
  EXPECT_THAT(why("3 N/", "N"), HasSubstr("a name is missing at the end"));
  EXPECT_THAT(why("3 m^0", "m"), HasSubstr("a power is a whole number from 1 to 9"));
  EXPECT_THAT(why("3 m^", "m"), HasSubstr("a power is a whole number from 1 to 9"));
  EXPECT_THAT(why("3 m99999999999", "m"), HasSubstr("a power is a whole number from 1 to 9"));
  EXPECT_THAT(why("3 m^0.25", "m"), HasSubstr("a power is a whole number from 1 to 9, or a half such as ^0.5"));
  EXPECT_THAT(why("3 (m^0.5)^0.5", "m"), HasSubstr("a root of a root"));
  EXPECT_THAT(why("3 ((((km^9)^9)^9)^9)^9", "m"), HasSubstr("powers too high"));
  EXPECT_THAT(why("3 ((((s^9)^9)^9)^9)^9", "m"), HasSubstr("powers too high"));
  EXPECT_THAT(why("3 m#", "m"), HasSubstr("missing before \"#\""));
  EXPECT_THAT(why("3 kmin", "s"), HasSubstr("unknown unit"));
  EXPECT_THAT(why("0x10 s", "s"), HasSubstr("unknown unit \"x\""));
  EXPECT_THAT(why("3 " + std::string(1000, '('), "m"), HasSubstr("too many brackets"));
}

/// A blank within a number does not cut it short: "15" is no 1 to the fifth.
TEST(Units, RefuseASecondNumber) {
  EXPECT_EQ(why("6 15 s", "s"),
            "\"6 15 s\": the number 15, where a name belongs, in the unit \"15 s\"; expected a time [s]");
  EXPECT_EQ(why("0.9 15", "1"),
            "\"0.9 15\": the number 15, where a name belongs, in the unit \"15\"; expected a pure number");
  for (const char* text : {"6 25 s", "0.9 1.5", "4 11/s", "4 1-2", "4 1^2", "2 s 12"})
    EXPECT_THROW((void)to_si(text, "s"), UnitError) << text;
}

TEST(Units, HeadersMayShoutOrSpellOut) {
  EXPECT_EQ(header_unit("MPH", "m/s"), "mph");
  EXPECT_EQ(header_unit(" KM/H", "m/s"), "km/h");
  for (const char* knots : {"kn", "kt", "kts", "Knot", "knots", "KNOTS"}) EXPECT_EQ(header_unit(knots, "m/s"), "kn");
  EXPECT_EQ(header_unit("Degrees", "rad"), "deg");
  EXPECT_EQ(header_unit("\xc2\xb0/s", "rad/s"), "deg/s");
  EXPECT_EQ(header_unit("Feet", "m"), "ft");
  EXPECT_EQ(header_unit("kN", "N"), "kN");
  EXPECT_EQ(header_unit("Degrees/sec", "rad/s"), "deg/s");
  EXPECT_EQ(header_unit("Nm", "N m"), "N m");
  EXPECT_EQ(header_unit("MPH", "m/s", false), "") << "as written only";
  EXPECT_EQ(header_unit("deg", "rad", false), "deg");
  EXPECT_EQ(header_unit("m", "s"), "") << "of another kind";
  EXPECT_EQ(header_unit("", "m"), "");
  EXPECT_EQ(header_unit("furlongs", "m"), "");
  EXPECT_DOUBLE_EQ(to_si("60 mph", "m/s"), 26.8224);
}

TEST(Units, ABadExpectedUnitIsAMistakeOfTheProgram) { EXPECT_THROW((void)to_si("3 m", "furlong"), std::logic_error); }

TEST(Units, EveryTextOfThreeSignsIsReadOrRefused) {
  const std::string signs = "1-+./^*() ,eEmskg%\xc2\xb2\xff";
  for (const char a : signs) {
    for (const char b : signs) {
      for (const char c : signs) {
        const std::string text{a, b, c};
        for (const std::string& quantity : {text, "1 " + text}) EXPECT_FALSE(why(quantity, "m").empty());
      }
    }
  }
}

struct DecimalComma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST(Units, DoNotDependOnTheLocale) {
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new DecimalComma));
  // No matter if the machine has none of these: then the C++ locale above is the whole test.
  const std::string c_before = std::setlocale(LC_NUMERIC, nullptr);
  for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "de_DE"}) {
    if (std::setlocale(LC_NUMERIC, name) != nullptr) break;
  }
  const double value = to_si("1234.5 mm", "m");
  std::setlocale(LC_NUMERIC, c_before.c_str());
  std::locale::global(before);
  EXPECT_EQ(value, 1.2345);
}

}  // namespace test_units
}  // namespace gripline
