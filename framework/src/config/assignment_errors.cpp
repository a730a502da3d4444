#include "config/assignment_errors.hpp"

#include <algorithm>
#include <tuple>

namespace gripline {
namespace {

bool same(const Diagnostic& a, const Diagnostic& b) {
  const auto key = [](const Diagnostic& d) { return std::tie(d.file, d.line, d.column, d.pointer, d.message); };
  return key(a) == key(b);
}

std::vector<Diagnostic> errors_of(const std::function<void(std::span<const std::string>)>& read,
                                  std::span<const std::string> assignments) {
  try {
    read(assignments);
  } catch (const InputError& error) {
    return {error.diagnostics().begin(), error.diagnostics().end()};
  } catch (const std::exception&) {
  }
  return {};
}

}  // namespace

InputError attribute_to_assignments(const InputError& error, std::span<const std::string> assignments,
                                    const std::function<void(std::span<const std::string>)>& read) {
  std::vector<std::vector<Diagnostic>> before;  // with none, one, two... of them
  for (std::size_t k = 0; k < assignments.size(); ++k) before.push_back(errors_of(read, assignments.first(k)));
  std::vector<Diagnostic> told(error.diagnostics().begin(), error.diagnostics().end());
  for (Diagnostic& one : told) {
    if (one.file == "--set" || assignments.empty()) continue;
    const auto had = std::ranges::find_if(before, [&](const std::vector<Diagnostic>& some) {
      return std::ranges::any_of(some, [&](const Diagnostic& d) { return same(d, one); });
    });
    if (had == before.begin()) continue;  // the file's own
    const std::string& cause = assignments[static_cast<std::size_t>(had - before.begin()) - 1];
    Diagnostic place = one;
    place.message.clear();
    place.contexts.clear();
    std::string where = place.text();
    while (where.ends_with(' ') || where.ends_with(':')) where.pop_back();
    if (!where.empty()) one.message += " (" + where + ")";
    one.file = "--set";
    one.line = one.column = 0;
    one.pointer = cause.substr(0, cause.find('='));
  }
  return InputError(std::move(told));
}

}  // namespace gripline
