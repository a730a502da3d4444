// What to drive next, so that a log tells apart what this one could not.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "diagnose/model/candidates.hpp"

namespace gripline::diagnose {

/// The manoeuvre, of those that effects declare (abi::PluginDecl::advice), that most of the effects in question share;
/// of equals the one they list first. Effects in all sets are not in question. Where no two share one: general advice.
std::string distinguishing_manoeuvre(std::span<const std::vector<std::string>> equals, const Catalogue& catalogue);

}  // namespace gripline::diagnose
