#pragma once
#include <array>
#include <compare>
#include <stdexcept>
#include <string>
#include <string_view>

namespace gripline {

/// A text that is not a quantity or a unit, or not of the kind expected; what() says which.
class UnitError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A physical dimension: exponents of length, mass, time, angle, current and temperature. Angle is a dimension of
/// its own here, so that "20 kg" and a bare "3" are both refused where an angle is expected. Exponents are counted in
/// halves: the strength of a random walk is a quantity per square root of a second.
struct Dimension {
  std::array<int, 6> halves{};  ///< twice the exponents of m, kg, s, rad, A, K
  bool operator==(const Dimension&) const = default;
};

/// A unit: its dimension and what one of it is in SI.
struct Unit {
  Dimension dimension;
  double factor = 1.0;

  /// Reads a unit: names with prefixes (mm, kN, mrad), powers (m2, s^-1, s^0.5), products ("N s", "N*s"), quotients
  /// (m/s2, "N s/m", "N/(m2/s2)"). "", "1" and "-" are pure numbers, "%" is a hundredth. `g` is gram. A product after a
  /// quotient needs brackets. Throws UnitError, with the nearest known name.
  [[nodiscard]] static Unit parse(std::string_view text);
};

/// "a time", "an angle", "a pure number", or "a quantity in kg/m".
[[nodiscard]] std::string describe(const Dimension& dimension);

/// "expected a time [s]", "expected a pure number": for messages about a value whose unit is declared as `unit`.
[[nodiscard]] std::string expectation(std::string_view unit);

/// A number with a unit, "20 deg" or "5 km/h", in SI; it must be of the kind of `expected_unit`. Independent of the
/// locale. Throws UnitError: `"6.2 m" is a length, expected a time [s]`. std::logic_error if `expected_unit` itself is
/// not a unit: that is a mistake of the program.
[[nodiscard]] double to_si(std::string_view text, std::string_view expected_unit);

/// What a logger's header calls a unit ("MPH", "degrees", "°/s"), as it is written here; empty if it is not, or not of
/// the kind of `expected_unit`. As written or, where `any_form`, in lower case or spelled out.
[[nodiscard]] std::string header_unit(std::string_view written, std::string_view expected_unit, bool any_form = true);

}  // namespace gripline
