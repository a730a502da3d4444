// Words for people: what to drive to tell effects apart, and the diagnosis in one sentence.
#pragma once

#include <string>
#include <vector>

namespace gripline::diagnose {

struct Diagnosis;

/// A manoeuvre that separates names the data cannot tell apart. Effects nobody wrote a line about get the general one.
std::string advice(const std::vector<std::vector<std::string>>& equals);

/// Place or kind, size, certainty.
std::string sentence(const Diagnosis& d);

}  // namespace gripline::diagnose
