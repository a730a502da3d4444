#include "diagnose/real_logs/real_sentence.hpp"

#include <algorithm>
#include <cmath>

#include "calibrate/fit/handling.hpp"
#include "diagnose/result/sentence.hpp"
#include "util/numbers.hpp"

namespace gripline::diagnose {
namespace {

std::string percent(double share) {
  const double value = 100.0 * share;
  return significant(value, std::abs(value) < 99.5 ? 2 : 3) + " %";
}

/// By how much an error became smaller, with its interval.
std::string decrease_text(const calibrate::ForecastChange& c) {
  return percent(-c.change) + " (" + percent(-c.high) + " to " + percent(-c.low) + ")";
}

/// What the starts that are predicted worst have in common.
std::string remainder_text(const Remainder& rest) {
  if (rest.share <= 0.0) return {};
  if (rest.of == "time")
    return percent(rest.share) + " of it lies in the third " +
           (rest.most ? "of the time at the end" : "at the beginning");
  std::string text = percent(rest.share);
  text += rest.most ? " of it lies in the third of the time with the largest "
                    : " of it lies in the third with the smallest ";
  text += rest.of == "steering" ? "steering to the left" : rest.of;
  text += rest.most ? " (from " : " (up to ";
  text += significant(rest.from, 3);
  text += rest.of == "speed" ? " m/s" : rest.of == "yaw rate" ? " rad/s" : rest.of == "steering" ? " rad" : "";
  return text + ")";
}

std::string effect_text(const MissingEffect& effect) {
  std::string text = effect.addition.name + " (";
  for (std::size_t p = 0; p < effect.params.size(); ++p) text += (p == 0 ? "" : ", ") + effect.params[p].text(3, false);
  return text + ")";
}

/// What calibration, and effects beside it, do to predictions.
std::string improvement_text(const MissingEffects& found) {
  std::string text = found.calibrated < found.given
                         ? "Calibrating the world takes " + decrease_text(found.calibration) + " off the error of "
                         : "Calibrating the world does not reduce the error of ";
  text += "predictions 1 s ahead of time that was not fitted";
  if (found.named.empty()) return text + ". ";
  text += "; ";
  for (std::size_t i = 0; i < found.named.size(); ++i) {
    text += i == 0 ? "" : i + 1 == found.named.size() ? " and " : ", ";
    text += effect_text(found.named[i]);
  }
  text += found.named.size() == 1 ? " takes " : " take ";
  return text + decrease_text(found.change) + " off what is left then. ";
}

/// The error that remains, beside what sensor noise alone would leave.
std::string remaining_text(const MissingEffects& found) {
  std::string text = "The normalised error that remains, " + significant(found.found, 3);
  const std::string noise = " (" + significant(found.noise, 3) + ")";
  if (found.at_noise())
    return text + ", is as large as the sensors' own noise" + noise + ": these logs show nothing more.";
  if (found.noise_too_large())
    text +=
        ", is less than sensor noise alone would leave by these logs" + noise +
        ": their noise is measured too large (motion passes for it), and whether more is missing is not told by it; ";
  else if (found.sum_at_noise())
    text += ", is in sum as large as the sensors' own noise" + noise + ", but the error of " +
            found.largest_over_noise.quantity + " is " + significant(found.largest_over_noise.times, 2) +
            " times its sensor's noise and unexplained: ";
  else if (found.noise > 0.0)
    text += " where sensor noise alone would leave " + significant(found.noise, 2) + ", is unexplained: ";
  else
    text += ", is unexplained: ";
  text += found.named.empty() ? "no effect" : "no other effect";
  text += " that was tried reduces it by enough, or with enough certainty, to be named";
  const std::string rest = remainder_text(found.remainder);
  return text + (rest.empty() ? "." : "; " + rest + ".");
}

}  // namespace

std::string real_sentence(const Diagnosis& d, const MissingEffects& found, const Cornering& corners) {
  std::string text;
  for (const NamedEffect& delay : d.delays) text += delay_sentence(delay);
  text += improvement_text(found);
  if (corners.by_log) text += calibrate::corners_text(*corners.by_log, corners.given) + " ";
  return text + remaining_text(found);
}

}  // namespace gripline::diagnose
