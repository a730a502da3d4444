// Parts of pages without scripts, and reading their JSON with everything optional.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace gripline::report {

/// A number, NaN for anything else.
double number_of(const nlohmann::json& value);
double number_in(const nlohmann::json& object, const char* key);
/// An array, empty for anything else.
const nlohmann::json& list_of(const nlohmann::json& object, const char* key);
std::string text_of(const nlohmann::json& object, const char* key);

/// Four significant digits; a dash for what is not a number.
std::string short_number(double value);
std::string html_table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows);
/// A part of the page that is closed until somebody opens it; empty where it has no content.
std::string html_folded(const std::string& title, const std::string& inside);
/// The page up to its first heading.
std::string html_begin(const std::string& title);

}  // namespace gripline::report
