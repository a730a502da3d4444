#include "diagnose/result/manoeuvre.hpp"

#include <algorithm>
#include <set>
#include <string_view>
#include <tuple>

namespace gripline::diagnose {
namespace {

/// Effects in some of the sets but not in all, by name.
std::set<std::string> in_question(std::span<const std::vector<std::string>> equals) {
  std::set<std::string> disputed;
  for (const auto& set : equals)
    for (const std::string& id : set)
      if (std::any_of(equals.begin(), equals.end(),
                      [&](const auto& other) { return std::find(other.begin(), other.end(), id) == other.end(); }))
        disputed.insert(id);
  return disputed;
}

/// Manoeuvres that an effect declares, separated by "; ".
std::vector<std::string_view> manoeuvres_of(std::string_view text) {
  constexpr std::string_view separator = "; ";
  std::vector<std::string_view> list;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(separator), text.size());
    if (end > 0) list.push_back(text.substr(0, end));
    text.remove_prefix(std::min(text.size(), end + separator.size()));
  }
  return list;
}

/// How many of the effects in question a manoeuvre helps, and how early they list it.
struct Manoeuvre {
  std::string_view text;
  std::size_t effects = 0, positions = 0;
};

}  // namespace

std::string distinguishing_manoeuvre(std::span<const std::vector<std::string>> equals, const Catalogue& catalogue) {
  std::vector<Manoeuvre> all;
  for (const std::string& id : in_question(equals)) {
    const std::size_t found = catalogue.find(id);
    if (found == catalogue.candidates().size()) continue;
    const auto list = manoeuvres_of(catalogue.candidates()[found].entry->decl->advice);
    for (std::size_t i = 0; i < list.size(); ++i) {
      auto at = std::find_if(all.begin(), all.end(), [&](const Manoeuvre& m) { return m.text == list[i]; });
      if (at == all.end()) at = all.insert(all.end(), Manoeuvre{list[i], 0, 0});
      ++at->effects;
      at->positions += i;
    }
  }
  const auto best = std::min_element(all.begin(), all.end(), [](const Manoeuvre& a, const Manoeuvre& b) {
    return std::tuple(b.effects, a.positions) < std::tuple(a.effects, b.positions);
  });
  return best != all.end() && best->effects > 1
             ? std::string(best->text)
             : "three laps or more at two different paces, and the same lap in the other direction";
}

}  // namespace gripline::diagnose
