// Texts of JSON for more than one test.
#pragma once

namespace gripline::testing_support {

/// A valid text with every construct of JSON and some of Unicode.
inline constexpr const char* every_construct = R"({
  "note": "größer als – and \u00e9\ud83d\ude00 \"quoted\" \\ \/ \b\f\n\r\t\u0001",
  "numbers": [0, -0.0, 1, -1.5, 2e3, 1.25E-3, 9007199254740991, 1e308, 5e-324, 0.1],
  "words": [true, false, null],
  "empty": [{}, [], ""],
  "deep": { "a": { "b": [[1, { "c": "d" }], 2] } }
})";

}  // namespace gripline::testing_support
