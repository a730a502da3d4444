#include "diagnose/result/sentence.hpp"

#include <algorithm>

namespace gripline::diagnose {
namespace {

std::string number(double value) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.3g", value);
  return buffer;
}

/// The named effects, with their sizes where they have few parameters.
std::string list(const Diagnosis& d) {
  std::string text;
  for (const NamedEffect& n : d.named) {
    text += (text.empty() ? "" : " and ") + n.effect;
    if (n.params.size() > 3) continue;
    std::string sizes;
    for (const NamedEffect::Value& v : n.params)
      sizes += (sizes.empty() ? " (" : ", ") + v.name + " = " + number(v.value) + (v.unit == "1" ? "" : " " + v.unit);
    text += sizes + ")";
  }
  return text;
}

/// Where the unexplained remainder is.
std::string where_text(const ResidualTest& test) {
  if (test.quantity == "noise")
    return std::string("as accelerations that look random, but in some directions only, and most by ") +
           where_names[static_cast<std::size_t>(test.where)];
  switch (test.where) {
    case Where::position:
      return "at lap fractions " + number(test.from) + " to " + number(test.to);
    case Where::time:
      if (test.quantity == "frequency") return "as an oscillation of " + number(test.from) + " Hz";
      return "between " + number(test.from) + " s and " + number(test.to) + " s";
    case Where::state:
      return "as a function of the state";
    case Where::input:
      return "as a function of the inputs";
  }
  return {};
}

}  // namespace

std::string sentence(const Diagnosis& d) {
  double least = 1.0;
  for (const NamedEffect& n : d.named) least = std::min(least, n.confidence);
  const std::string gap = "; on data not fitted the 1 s prediction error goes from " + number(d.gap.before) + " to " +
                          number(d.gap.after) + " sensor standard deviations";
  switch (d.verdict) {
    case Verdict::named:
      return list(d) + (d.named.size() == 1 ? " is" : " are") + " missing, with confidence " + number(least) + gap +
             ".";
    case Verdict::nothing_missing:
      return "Nothing is missing: no effect is supported at a false-alarm level of 1 %.";
    case Verdict::indistinguishable:
      return "Something is missing, but this log cannot tell apart " + std::to_string(d.equivalent.size()) +
             " explanations, of which " + list(d) + " fits best" + gap + "; to decide, " + d.manoeuvre + ".";
    case Verdict::unknown:
      return "Something is missing that no effect of the catalogue explains; it shows " + where_text(*d.unknown) +
             (d.named.empty() ? std::string() : ", besides " + list(d)) + ".";
  }
  return {};
}

}  // namespace gripline::diagnose
