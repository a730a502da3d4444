#include "report/html.hpp"

#include <cmath>

#include "report/packing.hpp"
#include "util/numbers.hpp"

namespace gripline::report {
namespace {

using nlohmann::json;

constexpr const char* style =
    "body{font:15px/1.5 system-ui,sans-serif;color:#1a1c20;max-width:960px;margin:2rem auto;padding:0 1rem}"
    "h1{font-size:1.5rem}h2{font-size:1.1rem;margin-top:2rem}table{border-collapse:collapse;font-size:13px;"
    "display:block;overflow-x:auto}th,td{text-align:left;padding:.2rem .8rem .2rem 0;border-bottom:1px solid #e3e5e8;"
    "font-variant-numeric:tabular-nums}svg{max-width:100%;height:auto}p,li{max-width:70ch}"
    ".lead{font-size:1.25rem;line-height:1.4;font-weight:600}summary{cursor:pointer;font-size:1.1rem;font-weight:700;"
    "margin-top:1.6rem}details>:not(summary){margin-top:.8rem}figure{margin:1rem 0;background:#fff;overflow-x:auto}"
    "@media(max-width:560px){body{margin:1rem auto}figure>svg{min-width:620px}}"
    "@media(prefers-color-scheme:dark){body{background:#111316;color:#eceded}th,td{border-color:#2b2f35}"
    "figure{border-radius:8px;filter:brightness(.92)}}";

}  // namespace

double number_of(const json& value) { return value.is_number() ? value.get<double>() : not_a_number; }

double number_in(const json& object, const char* key) {
  const auto found = object.find(key);
  return number_of(found != object.end() ? *found : json());
}

const json& list_of(const json& object, const char* key) {
  static const json empty = json::array();
  const auto found = object.find(key);
  return found != object.end() && found->is_array() ? *found : empty;
}

std::string text_of(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::string short_number(double value) { return std::isfinite(value) ? significant(value, 4) : "–"; }

std::string html_table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows) {
  std::string out = "<table><thead><tr>";
  for (const std::string& cell : head) out += "<th>" + html_escaped(cell) + "</th>";
  out += "</tr></thead><tbody>";
  for (const auto& row : rows) {
    out += "<tr>";
    for (const std::string& cell : row) out += "<td>" + html_escaped(cell) + "</td>";
    out += "</tr>";
  }
  return out + "</tbody></table>\n";
}

std::string html_folded(const std::string& title, const std::string& inside) {
  return inside.empty() ? "" : "<details><summary>" + html_escaped(title) + "</summary>\n" + inside + "</details>\n";
}

std::string html_begin(const std::string& title) {
  return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
         "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>" +
         html_escaped(title) + "</title><style>" + style + "</style></head><body>\n<h1>" + html_escaped(title) +
         "</h1>\n";
}

}  // namespace gripline::report
