#include "config/errors.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "config/ascii.hpp"
#include "config/node.hpp"

namespace gripline {
namespace {

std::string joined_lines(std::span<const Diagnostic> diagnostics) {
  std::string text;
  for (const Diagnostic& one : diagnostics) {
    if (!text.empty()) text += '\n';
    text += one.text();
  }
  return text;
}

/// Optimal string alignment distance: insertions, deletions, substitutions, and swaps of neighbours.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), now(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool same = lower_case(a[i - 1]) == lower_case(b[j - 1]);
      now[j] = std::min({last[j] + 1, now[j - 1] + 1, last[j - 1] + (same ? 0 : 1)});
      const bool swapped = i > 1 && j > 1 && lower_case(a[i - 1]) == lower_case(b[j - 2]) &&
                           lower_case(a[i - 2]) == lower_case(b[j - 1]);
      if (swapped) now[j] = std::min(now[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, now);
  }
  return last[b.size()];
}

}  // namespace

std::string escape_control(std::string_view text) {
  constexpr std::string_view hex = "0123456789abcdef";
  constexpr std::size_t longest = 4000;
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    // C1 controls are commands as well; in UTF-8 they stand behind 0xc2.
    const bool behind = byte >= 0x80 && byte < 0xa0 && i > 0 && text[i - 1] == '\xc2';
    if (byte < 0x20 || byte == 0x7f || behind) {
      if (behind) result.pop_back();
      result += std::string("\\x") + hex[byte >> 4U] + hex[byte & 0xfU];
    } else {
      result += text[i];
    }
    if (result.size() > longest && i + 1 < text.size()) return result + "...";
  }
  return result;
}

std::string Diagnostic::text() const {
  std::string where = file;
  if (line > 0) {
    where += ':' + std::to_string(line) + ':' + std::to_string(column);
    if (!pointer.empty()) where += ": " + pointer;
  } else if (!pointer.empty()) {
    where += (where.empty() ? "" : " ") + pointer;
  }
  std::string result = where.empty() ? message : where + ": " + message;
  for (std::size_t i = 0; i < contexts.size(); ++i) result += (i == 0 ? " [" : ", ") + contexts[i];
  if (!contexts.empty()) result += ']';
  return escape_control(result);
}

Diagnostic diagnostic_at(const Origin& origin, std::string message) {
  return {.file = origin.source ? origin.source->name : "",
          .line = origin.line,
          .column = origin.column,
          .pointer = origin.pointer,
          .message = std::move(message)};
}

InputError::InputError(std::vector<Diagnostic> diagnostics)
    : std::runtime_error(joined_lines(diagnostics)), diagnostics_(std::move(diagnostics)) {}

InputError::InputError(const Origin& origin, std::string message)
    : InputError(std::vector{diagnostic_at(origin, std::move(message))}) {}

InputError::InputError(const std::string& message) : InputError(std::vector{Diagnostic{.message = message}}) {}

void Errors::add(const Origin& origin, std::string message) { add(diagnostic_at(origin, std::move(message))); }

void Errors::add(Diagnostic diagnostic) {
  constexpr std::size_t most = 1000;
  ++added_;
  const std::string place = diagnostic.file + '\n' + std::to_string(diagnostic.line) + ':' +
                            std::to_string(diagnostic.column) + '\n' + diagnostic.pointer + '\n' + diagnostic.message;
  const auto known = known_.find(place);
  if (known == known_.end() && diagnostics_.size() >= most) {
    ++unlisted_;
    return;
  }
  const std::size_t index = known != known_.end() ? known->second : diagnostics_.size();
  if (known == known_.end()) {
    known_.emplace(place, index);
    diagnostics_.push_back(std::move(diagnostic));
  }
  std::vector<std::string>& contexts = diagnostics_[index].contexts;
  if (!context_.empty() && std::ranges::find(contexts, context_) == contexts.end()) contexts.push_back(context_);
}

void Errors::add(const Origin& origin, std::string message, Refuse refuse) {
  const std::size_t before = size();
  add(origin, std::move(message));
  of_machine_ += size() - before;
  refuse_ = refuse;
}

void Errors::add(const InputError& error) {
  for (const Diagnostic& one : error.diagnostics()) add(one);
}

std::vector<Diagnostic> Errors::sorted() const {
  std::vector<Diagnostic> result = diagnostics_;
  std::ranges::stable_sort(result, [](const Diagnostic& a, const Diagnostic& b) {
    return std::tie(a.file, a.line, a.column) < std::tie(b.file, b.line, b.column);
  });
  if (unlisted_ > 0) {
    Diagnostic rest{.file = result.back().file, .message = "and " + std::to_string(unlisted_) + " more errors"};
    result.push_back(std::move(rest));
  }
  return result;
}

void Errors::throw_if_any() const {
  if (diagnostics_.empty()) return;
  const InputError all(sorted());
  if (of_machine_ == size()) refuse_(all.what());
  throw all;
}

std::optional<std::string> nearest(std::string_view name, std::span<const std::string> candidates) {
  std::optional<std::string> best;
  std::size_t best_distance = std::max<std::size_t>(1, name.size() / 3) + 1;
  for (const std::string& candidate : candidates) {
    const std::size_t longer = std::max(name.size(), candidate.size());
    if (longer - std::min(name.size(), candidate.size()) >= best_distance) continue;  // too many letters apart
    const std::size_t d = distance(name, candidate);
    // A distance as long as the word is no similarity: any two short words are that near.
    if (d < best_distance && d < longer) {
      best = candidate;
      best_distance = d;
    }
  }
  return best;
}

std::string did_you_mean(std::string_view name, std::span<const std::string> candidates) {
  if (const auto best = nearest(name, candidates)) return "; did you mean \"" + *best + "\"?";
  if (candidates.empty()) return "";
  constexpr std::size_t most = 12;
  std::string list = "; known: ";
  for (std::size_t i = 0; i < std::min(most, candidates.size()); ++i) list += (i == 0 ? "" : ", ") + candidates[i];
  if (candidates.size() > most) list += ", ...";
  return list;
}

}  // namespace gripline
