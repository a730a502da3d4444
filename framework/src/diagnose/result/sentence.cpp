#include "diagnose/result/sentence.hpp"

#include <algorithm>
#include <cmath>

#include "util/numbers.hpp"

namespace gripline::diagnose {
namespace {

/// The named effects, with their sizes where they have few parameters, as the middle of a sentence.
std::string list(const Diagnosis& d) {
  std::string text;
  for (const NamedEffect& n : d.named) {
    if (!text.empty()) text += " and ";
    if (n.measurement) text += "in the measurement ";
    text += n.effect;
    if (n.params.size() > 3) continue;
    std::string sizes;
    for (const NamedEffect::Value& v : n.params)
      sizes +=
          (sizes.empty() ? " (" : ", ") + v.name + " = " + significant(v.value) + (v.unit == "1" ? "" : " " + v.unit);
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
      return "at lap fractions " + significant(test.from) + " to " + significant(test.to);
    case Where::time:
      if (test.quantity == "frequency") return "as an oscillation of " + significant(test.from) + " Hz";
      return "between " + significant(test.from) + " s and " + significant(test.to) + " s";
    case Where::state:
      return "as a function of the state";
    case Where::input:
      return "as a function of the inputs";
    case Where::reading:
      return "in the readings";
  }
  return {};
}

/// How far a channel is off. Which of those that disagree is wrong the log does not say.
std::string channel_text(const ChannelError& error) {
  const measured::ChannelInfo& channel = measured::channel_info[error.channel];
  return std::string(": those of ") + channel.words + " disagree with the others by " + significant(error.size) + " " +
         channel.unit + ", slowly, " + significant(error.ratio(), 2) + " times the noise that is stated";
}

/// What the result does to predictions.
std::string gap_text(const Gap& gap) {
  std::string text = "on data not fitted the 1 s prediction error goes from ";
  text += significant(gap.before);
  text += " to ";
  text += significant(gap.after);
  text += " sensor standard deviations";
  if (gap.closure > 0.0) {
    text += " (";
    text += significant(100.0 * gap.closure);
    text += " % of the gap, ";
    text += significant(100.0 * gap.closure_low);
    text += " to ";
    text += significant(100.0 * gap.closure_high);
    text += ")";
  } else {
    text += ", no more than chance";
  }
  return text;
}

/// What named effects do to predictions, beside refitted parameters and delays taken off.
std::string effect_on_predictions(const Diagnosis& d) {
  const Gap& gap = d.named_gap;
  const std::string with = d.named.size() == 1 ? "with it" : "with them";
  if (gap.closure > 0.0) return with + " " + gap_text(gap);
  std::string errors = significant(gap.before);
  errors += " sensor standard deviations, ";
  errors += significant(gap.after);
  errors += " ";
  errors += with;
  if (!gap.change.measured())
    return "the 1 s prediction error on data not fitted is " + errors + ", of too little data for an interval";
  return "the fitted data show it, 1 s predictions of data not fitted do not change significantly (" + errors + ")";
}

/// The error that refitting and taking delays off had to begin with.
std::string nominal_text(const Diagnosis& d) {
  if (d.nominal_fit.empty() && d.delays.empty()) return {};
  std::string text = "; ";
  text += significant(d.gap.before);
  text += " before ";
  if (!d.nominal_fit.empty()) text += "parameters were refitted";
  if (!d.delays.empty()) text += d.nominal_fit.empty() ? "delays were taken off" : " and delays taken off";
  return text;
}

/// The named effects, what they do, and with what confidence.
std::string found_text(const Diagnosis& d) {
  double least = 1.0;
  for (const NamedEffect& n : d.named) least = std::min(least, n.confidence);
  std::string text = list(d);
  if (d.named.front().measurement) text.front() = 'I';  // an effect's id has no capital
  text += d.named.size() == 1 ? " is missing: " : " are missing: ";
  text += effect_on_predictions(d);
  text += nominal_text(d);
  text += "; confidence ";
  return text + significant(least);
}

/// What figures of predictions are of where nothing but late channels was found.
std::string delays_taken_off(const Diagnosis& d) {
  return d.delays.size() == 1 ? "With this delay taken off the log, " : "With these delays taken off the log, ";
}

/// What refitted parameters and channels on time do where no effect is named.
std::string without_names(const Diagnosis& d) {
  std::string text;
  for (const auto& [name, value] : d.nominal_fit) {
    text += text.empty() ? "Refitted are " : ", ";
    text += name;
    text += " = ";
    text += significant(value);
  }
  return (text.empty() ? delays_taken_off(d) : text + ": ") + gap_text(d.gap);
}

/// What channels show late, in front of everything else; what it does to predictions where nothing else is said.
std::string delays_text(const Diagnosis& d) {
  std::string text;
  for (const NamedEffect& one : d.delays) text += delay_sentence(one);
  return text;
}

std::string car_text(const Diagnosis& d) {
  switch (d.verdict) {
    case Verdict::named:
      return found_text(d) + ".";
    case Verdict::nothing_missing:
      return "Nothing is missing: no effect is supported at a false-alarm level of 1 %.";
    case Verdict::indistinguishable: {
      std::string text = "Something is missing, but this log cannot tell apart ";
      text += std::to_string(d.equivalent.size());
      text += " explanations; ";
      text += list(d);
      text += " fits best: ";
      text += effect_on_predictions(d);
      text += "; to decide, ";
      return text + d.manoeuvre + ".";
    }
    case Verdict::unknown: {
      const std::string where = where_text(*d.unknown) + (d.wrong_channel ? channel_text(*d.wrong_channel) : "");
      const std::string found = !d.named.empty() ? found_text(d) : d.gap.closure > 0.0 ? without_names(d) : "";
      if (found.empty())
        return "Something is missing that no effect of the catalogue explains; it shows " + where + ".";
      return found + ". Beside that something is missing that no effect of the catalogue explains; it shows " + where +
             ".";
    }
  }
  return {};
}

}  // namespace

std::string delay_sentence(const NamedEffect& delay) {
  const NamedEffect::Value& t = delay.params.front();
  const std::string channels = delay.effect == "yaw_rate_delay"   ? "yaw-rate channel is "
                               : delay.effect == "yaw_delay"      ? "yaw channel is "
                               : delay.effect == "position_delay" ? "position channels are "
                                                                  : "speed channels are ";
  return "The " + channels + significant(t.value, 3) + " s late (" + significant(t.low, 3) + " to " +
         significant(t.high, 3) + "). ";
}

std::string sentence(const Diagnosis& d) {
  std::string text = delays_text(d);
  if (d.verdict != Verdict::named || !d.named.empty()) return text + car_text(d);
  return text + "Nothing else is missing. " + delays_taken_off(d) + gap_text(d.gap) + ".";
}

}  // namespace gripline::diagnose
